"""The allocation of least quadratic cost, without limits."""
