"""Binds the published allocation to the contract."""

import numpy as np

from components.allocator import plain
from components.allocator.commands import write_commands
from components.allocator.lagrange import MOST, ROW, WIDTH, newton_step
from components.allocator.published.limits import loop
from components.allocator.thrusters import width
from components.compiled import kernel
from components.contract import HEADER, Component, Sizes
from components.matrices import table

STEPS = 50
SAME = 1e-14  # of the largest thrusts' sum: a change of force that is none


class Published(plain.Plain):
    """Thrusters with largest thrusts and forbidden zones."""

    def vector(self) -> np.ndarray:
        """Number of thrusters and of zones, table (n, 7), zones (k, 3): thruster, first azimuth [rad], width [rad]."""
        zones = [(i, zone[0], width(zone)) for i, t in enumerate(self.thrusters) for zone in t.forbidden]
        return np.concatenate([[len(self.thrusters), len(zones)], self.table().ravel(), np.ravel(zones)])


@kernel
def allocate(p, u, x, y, w):
    """Loop over limits on the quadratic cost (24), then Newton's method on the power with the rows found (29)."""
    n, k = int(p[HEADER]), int(p[HEADER + 1])
    at = HEADER + 2 + n * WIDTH
    thrusters, zones = table(p, HEADER + 2, n, WIDTH), table(p, at, k, 3)
    f, best, free = table(w, 0, n, 2), table(w, 2 * n, n, 2), table(w, 4 * n, n, 2)
    inverse, rows = table(w, 6 * n, n, 3), table(w, 9 * n, n, ROW)
    at, size = (9 + ROW) * n, 3 + n
    S, b = table(w, at, size, size), w[at + size * size : at + size * size + size]
    count, is_done = loop(thrusters, zones, rows, u, x, inverse, free, S, b, f, best)
    left, scale = 0.0, 0.0
    for i in range(n):
        scale += thrusters[i, MOST]
    for _ in range(STEPS if is_done else 0):
        is_solved, change = newton_step(thrusters, rows, count, u, inverse, free, S, b, f)
        is_done, left = is_solved, change / scale
        if not is_solved or left <= SAME:
            break
    write_commands(thrusters, f, x, y, 1.0 if is_done and left <= 1e3 * SAME else 0.0)
    return 0


def init(t_ns, dt_ns, p, u, x, y, w):
    """Begin with thrusters ahead, then allocate."""
    for i in range(int(p[HEADER])):
        x[i] = 0.0
    return allocate(p, u, x, y, w)


def step(t_ns, dt_ns, p, u, x, y, w):
    """Allocate the demand at the step's end."""
    return allocate(p, u, x, y, w)


def sizes(published: Published) -> Sizes:
    """The azimuths; forces, rows and the system of their multipliers as scratch."""
    n = len(published.thrusters)
    return Sizes(state=n, workspace=(9 + ROW) * n + (3 + n) * (4 + n))


COMPONENT = Component(
    name="allocator.published",
    parameters=Published,
    inputs=plain.inputs,
    outputs=plain.outputs,
    sizes=sizes,
    init=init,
    step=step,
    assumptions="van Daalen et al. 2011, eqs. 20 to 29, as printed, for comparison: thrusters may still be "
    "asked for more than they have, or in a forbidden zone; allocator.exact keeps all limits.",
)
