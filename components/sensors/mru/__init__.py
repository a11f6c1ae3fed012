"""A motion reference unit."""
