"""Winches."""
