"""The commands of `towline`, one a module."""
