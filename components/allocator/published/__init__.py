"""The allocation of van Daalen et al. 2011 with its loop over limits, as printed, for comparison."""
