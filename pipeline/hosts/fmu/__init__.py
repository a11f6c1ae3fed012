"""Host of anyone's FMUs: FMI 1.0, 2.0 and 3.0, called through their C functions."""
