"""The dynamic elastic line."""
