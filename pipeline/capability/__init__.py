"""Capability of a vessel on dynamic positioning: the wind up to which its thrusters hold it."""
