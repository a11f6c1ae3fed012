"""A point on an ellipse."""
