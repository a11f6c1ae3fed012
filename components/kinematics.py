"""Angles, and turning vectors from a vessel's body frame to the world's."""

from math import cos, floor, pi, sin

from components.compiled import kernel


@kernel
def wrapped(angle):
    """The angle [rad] in [-pi, pi)."""
    return angle - 2.0 * pi * floor(angle / (2.0 * pi) + 0.5)


@kernel
def to_world(roll, pitch, yaw, x, y, z):
    """A vector in the body frame as north, east, down; rotations about z, y, x (Fossen 2011, eq. 2.18)."""
    cr, sr, cp, sp, cy, sy = cos(roll), sin(roll), cos(pitch), sin(pitch), cos(yaw), sin(yaw)
    across, below = cr * y - sr * z, sr * y + cr * z
    ahead, below = cp * x + sp * below, cp * below - sp * x
    return cy * ahead - sy * across, sy * ahead + cy * across, below


@kernel
def to_body(roll, pitch, yaw, north, east, down):
    """A vector in the world in the body frame."""
    cr, sr, cp, sp, cy, sy = cos(roll), sin(roll), cos(pitch), sin(pitch), cos(yaw), sin(yaw)
    ahead, across = cy * north + sy * east, cy * east - sy * north
    ahead, below = cp * ahead - sp * down, sp * ahead + cp * down
    return ahead, cr * across + sr * below, cr * below - sr * across
