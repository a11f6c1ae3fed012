"""Wind on what a vessel has above the water, by Blendermann's coefficients."""

from math import atan2, pi, sqrt

from components.compiled import kernel

# rho/2 times frontal and lateral area [kg/m], length overall [m], centroid of the lateral area ahead of the reference
# point over that length, then C_D,t, C_D,l,AF from ahead and from astern, and delta.
FRONT, SIDE, LENGTH, CENTROID, CROSS, AHEAD, ASTERN, DELTA = range(8)
COEFFICIENTS = 8


@kernel
def blow(k, u, v):
    """Surge force [N], sway force [N] and yaw moment [N m] of the air that a vessel moves through with u, v [m/s].

    Blendermann 1994 (J. Wind Eng. Ind. Aerodyn. 51, 339-351); Fossen 2011, eqs. 8.30 to 8.34. The angle gamma is that
    of the wind's origin to the bow; the moment's formula holds for 0 to 180 deg and is mirrored for the other side.
    """
    square = u * u + v * v
    if square == 0.0:
        return 0.0, 0.0, 0.0
    speed = sqrt(square)
    c, s = u / speed, -v / speed
    along = k[AHEAD] if u > 0.0 else k[ASTERN]
    double = 2.0 * s * c
    lengthwise = along * k[FRONT] / k[SIDE]
    shape = 1.0 - 0.5 * k[DELTA] * (1.0 - lengthwise / k[CROSS]) * double * double
    x = -square * k[FRONT] * along * c / shape
    y = square * k[SIDE] * k[CROSS] * s / shape
    return x, y, (k[CENTROID] - 0.18 * (atan2(abs(s), c) - 0.5 * pi)) * k[LENGTH] * y
