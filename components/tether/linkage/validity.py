"""How far the chain is inside or outside its validity range; 1 at the border."""

from math import acos, asin, sqrt

from components.compiled import kernel
from components.contract import Port
from components.tether.catenary.validity import INERTIA, LARGEST, RANGE, half_depth, write

# Angle between neighbours beyond which segments are too coarse for a rope [rad]; part of the largest tension with which
# a rope, which bears none, may be pressed; part of its length by which it may be stretched.
TURN_BORDER, PUSH_BORDER, STRETCH_BORDER = 0.5, 0.1, 0.01

TURN = Port("validity.turn", "1", (), "", "largest angle between neighbouring segments over 0.5 rad")
PUSH = Port("validity.push", "1", (), "", "largest compression over a tenth of the largest tension: ropes bear none")
STRETCH = Port("validity.stretch", "1", (), "", "stretch that the ends' distance forces on rigid segments, over 1 %")


@kernel
def inertia(mass, acceleration, length, chord, load, shift):
    """Shift of the line by the inertia that is left out, over the tolerated one.

    mass: per length [kg/m]; acceleration: of the harder accelerated end [m/s^2]; load: mean of the water's [N/m].
    """
    if mass * acceleration == 0.0:
        return 0.0
    return mass * acceleration * half_depth(length, min(chord, length)) / (load * shift) if load > 0.0 else LARGEST


@kernel
def assess(y, at, inner, outer, least, most, stretch, neglected):
    """Write the measures from y[at] on.

    inner, outer: least inner and largest outer product of neighbouring directions; least and largest tension [N];
    neglected: the measure of inertia, below 0 where it is in the model or not known.
    """
    turned = (asin(min(outer, 1.0)) if inner > 0.0 else acos(max(inner, -1.0))) / TURN_BORDER
    push = 0.0
    if least < 0.0:
        push = -least / (PUSH_BORDER * most) if most > -1e-3 * least else LARGEST
    write(y, at, (turned, push, abs(stretch) / STRETCH_BORDER, neglected))


@kernel
def size(x, y):
    """Length of a vector."""
    return sqrt(x * x + y * y)


def ports(inertia: bool) -> tuple[Port, ...]:
    """Ports of the measures, behind their largest."""
    return (RANGE, TURN, PUSH, STRETCH, *((INERTIA,) if inertia else ()))
