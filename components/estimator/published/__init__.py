"""The linear Kalman filter of a riser as printed in Trigo et al. 2014."""
