"""An extended Kalman filter of an ROV's tether, with the line at rest in a current as its model."""
