"""A drum that pays a line out and hauls it in at a commanded speed."""
