"""How far a quasi-static line is inside or outside its validity range; the measures are those of the catenary.

Drag is in the model; what it leaves out are inertia, waves of the ends' unsteady motion and bending. The error of the
mesh is judged with the same tolerance.
"""

from components.compiled import kernel
from components.contract import Port
from components.tether.catenary.validity import (
    BENDING,
    INERTIA,
    RANGE,
    STRAIN,
    STRAIN_BORDER,
    WAVE,
    Range,
    bending_length,
    half_depth,
    numbers,
    outrun,
    write,
)

__all__ = ["Range", "assess", "half_depth", "numbers", "ports"]

MESH = Port("validity.mesh", "1", (), "", "estimated error of the mesh over the tolerated shift")


@kernel
def assess(y, at, limits, error, unsteady, acceleration, yields, T_least, T_most, q):
    """Write the measures that are given, from y[at] on.

    error: of the mesh [m]; unsteady: speed of the ends against each other [m/s]; acceleration: the larger of the ends'
    [m/s^2]; yields: shift of the line by a load across it of 1 N/m [m^2/N]; least and largest tension [N]; q: mean
    load [N/m].
    """
    mesh, strain = error / limits.shift, limits.flexibility * T_most / STRAIN_BORDER
    inertia = wave = bending = -1.0
    if limits.mass > 0.0:
        inertia = limits.mass * acceleration * yields / limits.shift
        wave = outrun(unsteady, T_least, limits.mass)
    if limits.EI > 0.0:
        bending = bending_length(limits.EI, T_least, q) / limits.shift
    write(y, at, (mesh, inertia, wave, bending, strain))


def ports(mass: bool, bending: bool) -> tuple[Port, ...]:
    """Ports of the measures that can be assessed, behind their largest."""
    return (RANGE, MESH, *((INERTIA, WAVE) if mass else ()), *((BENDING,) if bending else ()), STRAIN)
