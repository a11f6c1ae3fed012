"""A demand from a record."""
