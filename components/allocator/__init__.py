"""Allocators: what each thruster is to give so that together they give the demand."""
