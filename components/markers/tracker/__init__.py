"""Tracked markers along a line."""
