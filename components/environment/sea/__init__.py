"""An irregular sea."""
