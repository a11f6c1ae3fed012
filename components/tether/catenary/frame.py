"""The plane in which a line hangs in a uniform load field: upright means against the load, whatever its direction."""

from math import sqrt
from typing import NamedTuple

from components.compiled import kernel

# A load below this [N/m] is none: products with it would underflow, and no line that it could bend is finite.
LIGHTEST = 1e-200


class Frame(NamedTuple):
    """Unit vectors in NED: `up` against the load, `along` from end a towards end b across it."""

    up_x: float
    up_y: float
    up_z: float
    along_x: float
    along_y: float
    along_z: float


@kernel
def norm(x, y, z):
    """Length of a vector, without overflow."""
    largest = max(abs(x), abs(y), abs(z))
    if largest == 0.0:
        return 0.0
    x, y, z = x / largest, y / largest, z / largest
    return largest * sqrt(x * x + y * y + z * z)


@kernel
def hanging_frame(qx, qy, qz, dx, dy, dz):
    """(frame, size of the load, span, rise) for the load q and the vector d from end a to end b, NED.

    Span and rise are d's parts across and against the load, so that a vertical catenary, an inclined one (Drupt et al.
    2022, eqs. 6-8) and one towed across the water (Bhattacharya et al. 2011, eq. 9) are one problem. Without a load
    the span is all of d.
    """
    w = norm(qx, qy, qz)
    w = w if w > LIGHTEST else 0.0
    ux, uy, uz = (-qx / w, -qy / w, -qz / w) if w > 0.0 else (0.0, 0.0, 0.0)
    rise = dx * ux + dy * uy + dz * uz
    hx, hy, hz = dx - rise * ux, dy - rise * uy, dz - rise * uz
    rest = hx * ux + hy * uy + hz * uz  # what rounding left along the load in a steep line
    hx, hy, hz = hx - rest * ux, hy - rest * uy, hz - rest * uz
    span = norm(hx, hy, hz)
    if span > 0.0:
        return Frame(ux, uy, uz, hx / span, hy / span, hz / span), w, span, rise
    # The ends stand above each other: north, or east where the load is along north.
    hx, hy, hz = (1.0 - ux * ux, -ux * uy, -ux * uz) if abs(ux) < 0.9 else (-ux * uy, 1.0 - uy * uy, -uy * uz)
    size = norm(hx, hy, hz)
    return Frame(ux, uy, uz, hx / size, hy / size, hz / size), w, 0.0, rise
