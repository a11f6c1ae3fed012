"""Moves messages: scenario, graph, conductor, log and command line."""
