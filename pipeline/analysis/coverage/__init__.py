"""What a line between two boats sweeps: in steady tow by theory, and really in a log."""
