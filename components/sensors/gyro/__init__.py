"""A gyrocompass."""
