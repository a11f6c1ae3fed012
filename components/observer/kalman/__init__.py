"""An extended Kalman filter."""
