"""A stick held in a hand."""
