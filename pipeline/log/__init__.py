"""The log: one MCAP file that holds the whole experiment."""
