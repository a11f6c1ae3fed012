"""Points of a floating rope as a boat's camera sees them."""
