"""Prescribed motions and other sources of movement."""
