"""A pinhole camera with radial distortion in the water of a tank: where it sees a point, and what ray a pixel sees.

Camera axes: x right and y down in the image, z ahead. Pixels have whole coordinates in their middle, from (0, 0) on.
A flat port's refraction is taken into the focal length (that in air times 1.33) and the distortion.
"""

from math import cos, sin
from typing import NamedTuple

import numpy as np

from components.compiled import kernel

NEWTON_STEPS = 8  # of the inverse distortion, from the undistorted radius: 1e-12 for |k r^2| < 0.2


class Optics(NamedTuple):
    """north, east, down: of the camera [m]; turn: (9,) rows right, down, ahead in NED; f: focal length [pixel].

    cu, cv: principal point [pixel]; k: radial distortion, r_d = r (1 + k r^2) with r in focal lengths.
    """

    north: float
    east: float
    down: float
    turn: np.ndarray
    f: float
    cu: float
    cv: float
    k: float


def turn_of(heading: float, pitch: float, roll: float) -> np.ndarray:
    """Rows right, down and ahead of the camera in NED, (9,).

    heading of its view from north, pitch of it above the horizon, roll clockwise as seen from behind the camera [rad].
    """
    ahead = np.array([cos(pitch) * cos(heading), cos(pitch) * sin(heading), -sin(pitch)])
    level = np.array([-sin(heading), cos(heading), 0.0])
    plumb = np.cross(ahead, level)
    right = cos(roll) * level + sin(roll) * plumb
    return np.concatenate([right, np.cross(ahead, right), ahead])


@kernel
def project(optics, north, east, down):
    """Pixel (u, v) of a point, and its depth ahead of the camera [m], at most 0 behind it (then the pixel is void)."""
    turn = optics.turn
    dn, de, dd = north - optics.north, east - optics.east, down - optics.down
    z = turn[6] * dn + turn[7] * de + turn[8] * dd
    if z <= 0.0:
        return 0.0, 0.0, z
    x = (turn[0] * dn + turn[1] * de + turn[2] * dd) / z
    y = (turn[3] * dn + turn[4] * de + turn[5] * dd) / z
    s = optics.f * (1.0 + optics.k * (x * x + y * y))
    return optics.cu + s * x, optics.cv + s * y, z


@kernel
def ray(optics, u, v):
    """Direction of what a pixel sees, NED; its component ahead of the camera is 1."""
    x, y = (u - optics.cu) / optics.f, (v - optics.cv) / optics.f
    rd2 = x * x + y * y
    g = 1.0  # r = g r_d, where g (1 + k r_d^2 g^2) = 1
    for _ in range(NEWTON_STEPS):
        g -= (g * (1.0 + optics.k * rd2 * g * g) - 1.0) / (1.0 + 3.0 * optics.k * rd2 * g * g)
    x, y, turn = g * x, g * y, optics.turn
    return (
        turn[0] * x + turn[3] * y + turn[6],
        turn[1] * x + turn[4] * y + turn[7],
        turn[2] * x + turn[5] * y + turn[8],
    )


@kernel
def plane_derivatives(optics, north, east, down):
    """Derivatives of the pixel by north and down: du/dn, du/dd, dv/dn, dv/dd [pixel/m], by central differences."""
    h = 1e-4  # [m]: truncation 1e-9 and rounding 1e-11 of the derivative at some metres' distance
    u1, v1, _ = project(optics, north + h, east, down)
    u0, v0, _ = project(optics, north - h, east, down)
    u3, v3, _ = project(optics, north, east, down + h)
    u2, v2, _ = project(optics, north, east, down - h)
    return 0.5 * (u1 - u0) / h, 0.5 * (u3 - u2) / h, 0.5 * (v1 - v0) / h, 0.5 * (v3 - v2) / h
