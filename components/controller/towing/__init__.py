"""A boat that tows along a path, abeam of another one."""
