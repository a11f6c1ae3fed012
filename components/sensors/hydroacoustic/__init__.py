"""Hydroacoustic positioning."""
