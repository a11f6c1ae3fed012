"""Waypoint control of an ROV."""
