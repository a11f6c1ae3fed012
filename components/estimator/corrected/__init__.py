"""The linear Kalman filter of a riser with the equations corrected."""
