"""The allocation of least power without limits, by Newton's method from the quadratic one."""
