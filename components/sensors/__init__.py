"""What measures a vessel and its surroundings, with the faults that such instruments have."""
