"""Cameras: images of a scene, or from a film."""
