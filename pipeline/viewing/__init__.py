"""What other programs than browsers show of a log: a recording for Rerun, with a layout that is ready."""
