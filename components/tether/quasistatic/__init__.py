"""The line at rest in a current, or towed steadily."""
