"""Reads logs and nothing else: fits, indicators, tables, figures."""
