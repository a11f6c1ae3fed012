"""Lines in the water, each fidelity a component."""
