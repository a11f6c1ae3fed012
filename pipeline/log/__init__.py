"""The log of a run: one MCAP file, written in bulk and read back as arrays."""
