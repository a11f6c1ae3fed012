"""Physics and control as compiled components; knows nothing of files, clocks and networks."""
