"""Feedback of thrusters."""
