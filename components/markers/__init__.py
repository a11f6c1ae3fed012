"""Markers on lines, as a motion-capture system sees them."""
