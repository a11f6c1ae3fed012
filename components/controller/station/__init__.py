"""Dynamic positioning of a vessel."""
