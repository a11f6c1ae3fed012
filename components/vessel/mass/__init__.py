"""A rigid mass on springs and dampers."""
