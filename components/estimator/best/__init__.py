"""An iterated extended Kalman filter of a line as a chain of bars."""
