"""Markers of a line found in images."""
