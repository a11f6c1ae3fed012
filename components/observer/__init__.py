"""Observers: what a vessel does, from its instruments."""
