"""Which law of drag, and which ratio of its coefficients, the shape of a towed line shows."""
