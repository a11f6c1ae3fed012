"""How far a static line is inside or outside its validity range: what it leaves out, as a shift of its shape.

Each measure is 1 at the border. What a static model leaves out (inertia, drag, bending) would shift the line by some
length; the border is where the estimate of that shift comes to `tolerance` of the line's length, by default the 1 % by
which Drupt et al. 2022 judge the catenary. The shifts are first-order estimates: they tell inside from outside, and
are no error bounds. A measure is there only where the parameters that it needs are given; without a virtual mass the
inertia is that of the load over g, which is less than the truth.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from components.compiled import kernel
from components.constants import GRAVITY
from components.contract import Port

# Ropes break at 10 to 20 % of strain, so that one EA has no meaning beyond the first figure.
STRAIN_BORDER = 0.1
# A measure stays finite, as every output must, also where the line has no tension at all.
LARGEST = 1e9

RANGE = Port("validity.range", "1", (), "", "the largest of the measures below; 1 at the border of validity")
DRAG = Port("validity.drag", "1", (), "", "shift by the drag at the faster end's speed over the tolerated one")
INERTIA = Port("validity.inertia", "1", (), "", "shift by the inertia at the harder accelerated end, tolerated: 1")
WAVE = Port("validity.wave", "1", (), "", "end's speed over the speed sqrt(T/m) of transverse waves at it")
BENDING = Port("validity.bending", "1", (), "", "bending length, the shift of a clamped line, over the tolerated one")
STRAIN = Port("validity.strain", "1", (), "", "largest strain over 0.1, beyond which ropes have no single EA")


class Range(NamedTuple):
    """What a static line is judged with; a figure of 0 is not given and not judged.

    shift: tolerated shift [m]; mass: per length, virtual [kg/m]; drag: rho d C_n / 2 [kg/m^2]; EI: [N m^2].
    """

    shift: float
    mass: float
    drag: float
    EI: float
    flexibility: float


@kernel
def half_depth(length, chord):
    """Largest distance of a line of this length from its chord: the half axis of the ellipse about both ends."""
    return 0.5 * sqrt(max((length - chord) * (length + chord), 0.0))


@kernel
def speed(u, end):
    """Speed and size of the acceleration of the end whose motion bundle begins at u[end]."""
    v = sqrt(u[end + 3] * u[end + 3] + u[end + 4] * u[end + 4] + u[end + 5] * u[end + 5])
    return v, sqrt(u[end + 6] * u[end + 6] + u[end + 7] * u[end + 7] + u[end + 8] * u[end + 8])


@kernel
def outrun(v, T, m):
    """Speed v over the speed of transverse waves, sqrt(T/m)."""
    return min(v * sqrt(m / T), LARGEST) if T > 0.0 else (LARGEST if v > 0.0 else 0.0)


@kernel
def bending_length(EI, T, q):
    """Length over which a clamped end turns into the line: sqrt(EI/T), and (EI/q)^(1/3) where that is less."""
    tense = sqrt(EI / T) if T > 0.0 else LARGEST
    return min(tense, (EI / q) ** (1.0 / 3.0)) if q > 0.0 else tense


@kernel
def write(y, at, values):
    """The measures behind their largest; those below 0 are not assessed and have no place."""
    count = 0
    worst = 0.0
    for value in values:
        if value >= 0.0:
            count += 1
            y[at + count] = min(value, LARGEST)
            worst = max(worst, y[at + count])
    if count > 0:
        y[at] = worst


@kernel
def assess(y, at, u, a, b, limits, drag_speed, yields, T_a, T_b, T_least, T_most, q):
    """Write the measures that are given, from y[at] on.

    a, b: where the ends' motions begin in u. drag_speed: of the water past the line that the model leaves out [m/s].
    yields: shift of the line by a load across it of 1 N/m [m^2/N]. Tensions [N] at the ends, the least and the most.
    """
    v_a, acc_a = speed(u, a)
    v_b, acc_b = speed(u, b)
    mass = limits.mass if limits.mass > 0.0 else q / GRAVITY
    inertia = mass * max(acc_a, acc_b) * yields / limits.shift
    wave = max(outrun(v_a, T_a, mass), outrun(v_b, T_b, mass)) if mass > 0.0 else 0.0
    drag = bending = strain = -1.0
    if limits.drag > 0.0:
        drag = limits.drag * drag_speed * drag_speed * yields / limits.shift
    if limits.EI > 0.0:
        bending = bending_length(limits.EI, T_least, q) / limits.shift
    if limits.flexibility > 0.0:
        strain = limits.flexibility * T_most / STRAIN_BORDER
    write(y, at, (drag, inertia, wave, bending, strain))


def ports(drag: bool, bending: bool, strain: bool) -> tuple[Port, ...]:
    """Ports of the measures that can be assessed, behind their largest."""
    drags, bends, strains = ((port,) if on else () for port, on in ((DRAG, drag), (BENDING, bending), (STRAIN, strain)))
    return (RANGE, *drags, INERTIA, WAVE, *bends, *strains)


def numbers(shift: float, mass: float | None, drag: float, EI: float | None, flexibility: float) -> np.ndarray:
    """The fields of Range for the vector p: (5,) float64."""
    return np.array(Range(shift, mass or 0.0, drag, EI or 0.0, flexibility), np.float64)
