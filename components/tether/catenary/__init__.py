"""The static line in a uniform load field, in closed form."""
