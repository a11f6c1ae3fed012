"""The report: one page without other files or network, a tab for each subject that the log has data of."""
