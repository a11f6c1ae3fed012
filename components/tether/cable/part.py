"""The constants of one segment: the line's own, or those of the section it lies in."""

from typing import NamedTuple

from components.compiled import kernel

PART = 11  # numbers of a segment in p: the constants from l0 to stiff but tau, and the weight hung before it


class Part(NamedTuple):
    """As the fields of Line; stiff: EI [N m^2]."""

    l0: float
    k: float
    tau: float
    mass: float
    added_n: float
    added_t: float
    weight: float
    drag_n: float
    drag_t: float
    displaced: float
    stiff: float
    tension_only: int
    inextensible: int


@kernel
def whole(line):
    """What every segment of a uniform line is."""
    return Part(
        line.l0, line.k, line.tau, line.mass, line.added_n, line.added_t, line.weight, line.drag_n, line.drag_t,
        line.displaced, line.stiff, line.tension_only, line.inextensible,
    )  # fmt: skip


@kernel
def part(line, i):
    """The segment i."""
    if line.parts == 0:
        return whole(line)
    p, k = line.table, line.parts + i * PART
    return Part(
        p[k], p[k + 1], line.tau, p[k + 2], p[k + 3], p[k + 4], p[k + 5], p[k + 6], p[k + 7], p[k + 8], p[k + 9],
        line.tension_only, line.inextensible,
    )  # fmt: skip


@kernel
def span(line, i):
    """Half the length of the segments that meet at node i [m]."""
    before = part(line, i - 1).l0 if i > 0 else 0.0
    return 0.5 * (before + (part(line, i).l0 if i < line.n else 0.0))


@kernel
def hung(line, i):
    """Weight in the fluid of all that hangs on the nodes 1..i, half the first segment not counted [N]."""
    return 2.0 * i * line.weight if line.parts == 0 else line.table[line.parts + i * PART + 10]
