"""What is asked of an estimator off line: its consistency, its noises, and its states smoothed."""
