"""A satellite receiver."""
