"""A load cell."""
