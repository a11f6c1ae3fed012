"""Propellers and thrusters that follow commands."""
