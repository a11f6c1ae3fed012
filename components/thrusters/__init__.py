"""What moves vessels: propellers, thrusters and rudders."""
