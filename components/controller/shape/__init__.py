"""Control of a towed line by its two ends."""
