"""The water around vessels and lines, and the air: currents, waves and wind."""
