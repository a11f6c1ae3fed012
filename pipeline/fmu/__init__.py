"""Export of a component as an FMU that needs no Python."""
