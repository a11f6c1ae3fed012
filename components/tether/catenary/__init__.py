"""The static line in closed form."""
