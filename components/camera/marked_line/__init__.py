"""A rendered image of a marked line in a tank."""
