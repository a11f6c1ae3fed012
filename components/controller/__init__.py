"""Controllers: the load that brings a vehicle where it should be."""
