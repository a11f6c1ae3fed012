"""The water around vessels and lines: currents and waves."""
