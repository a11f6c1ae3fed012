"""A chain of rigid segments in a plane."""
