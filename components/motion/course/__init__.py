"""A vessel's course through points at given times."""
