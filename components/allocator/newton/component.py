"""Binds the allocation of least power without limits to the contract."""

from components.allocator import plain
from components.allocator.commands import write_commands
from components.allocator.lagrange import MOST, ROW, WIDTH, least_quadratic, newton_step
from components.compiled import kernel
from components.contract import HEADER, Component, Sizes
from components.matrices import table

STEPS = 50
SAME = 1e-14  # of the largest thrusts' sum: a change of force that is none


@kernel
def allocate(p, u, x, y, w):
    """Allocate the demand."""
    n = int(p[HEADER])
    thrusters = table(p, HEADER + 1, n, WIDTH)
    f, inverse, free = table(w, 0, n, 2), table(w, 2 * n, n, 3), table(w, 5 * n, n, 2)
    S, b, rows = table(w, 7 * n, 3, 3), w[7 * n + 9 : 7 * n + 12], table(w, 0, 0, ROW)
    if not least_quadratic(thrusters, rows, 0, u, inverse, free, S, b, f):
        for i in range(n):
            f[i, 0] = f[i, 1] = 0.0
        write_commands(thrusters, f, x, y, 0.0)
        return 0
    done, left, scale = True, 1.0, 0.0
    for i in range(n):
        scale += thrusters[i, MOST]
    for _ in range(STEPS):
        done, change = newton_step(thrusters, rows, 0, u, inverse, free, S, b, f)
        left = change / scale
        if not done or left <= SAME:
            break
    write_commands(thrusters, f, x, y, 1.0 if done and left <= 1e3 * SAME else 0.0)
    return 0


def init(t_ns, dt_ns, p, u, x, y, w):
    """Begin with thrusters ahead, then allocate."""
    for i in range(int(p[HEADER])):
        x[i] = 0.0
    return allocate(p, u, x, y, w)


def step(t_ns, dt_ns, p, u, x, y, w):
    """Allocate the demand at the step's end."""
    return allocate(p, u, x, y, w)


COMPONENT = Component(
    name="allocator.newton",
    parameters=plain.Plain,
    inputs=plain.inputs,
    outputs=plain.outputs,
    sizes=lambda one: Sizes(state=len(one.thrusters), workspace=7 * len(one.thrusters) + 12),
    init=init,
    step=step,
    assumptions="Exact power, but no limits: thrusters may be asked for more than they have, in any direction. "
    "van Daalen et al. 2011, eqs. 16 to 19.",
)
