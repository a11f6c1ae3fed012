"""Binds the allocation of least power without limits to the contract."""

from components.allocator import plain
from components.allocator.commands import write_commands
from components.allocator.lagrange import MOST, newton_step
from components.allocator.unlimited import lay_out, sizes, solve_quadratic
from components.compiled import kernel
from components.contract import HEADER, Component

STEPS = 50
SAME = 1e-14  # of the largest thrusts' sum: a change of force that is none


@kernel
def allocate(p, u, x, y, w):
    """Allocate the demand, from the quadratic optimum on."""
    is_done, left, scale = solve_quadratic(p, u, w), 0.0, 0.0
    thrusters, f, inverse, free, S, b, rows = lay_out(p, w)
    for i in range(f.shape[0]):
        scale += thrusters[i, MOST]
    for _ in range(STEPS if is_done else 0):
        is_done, change = newton_step(thrusters, rows, 0, u, inverse, free, S, b, f)
        left = change / scale
        if not is_done or left <= SAME:
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


COMPONENT = Component(
    name="allocator.newton",
    parameters=plain.Plain,
    inputs=plain.inputs,
    outputs=plain.outputs,
    sizes=sizes,
    init=init,
    step=step,
    assumptions="Exact power, but no limits: thrusters may be asked for more than they have, in any direction. "
    "van Daalen et al. 2011, eqs. 16 to 19.",
)
