"""The allocation of least power under all limits, by its dual of three unknowns."""
