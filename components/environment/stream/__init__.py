"""A current over depth that varies slowly."""
