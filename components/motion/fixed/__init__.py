"""A point at rest."""
