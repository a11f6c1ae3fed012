"""A vessel at low speed: surge, sway and yaw by forces, and its motion in waves."""
