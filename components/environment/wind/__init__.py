"""Wind with gusts."""
