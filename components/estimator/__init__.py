"""Estimators of a line's shape and tension from few sensors on it."""
