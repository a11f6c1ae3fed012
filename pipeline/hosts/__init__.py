"""Where components run."""
