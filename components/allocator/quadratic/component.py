"""Binds the quadratic allocation to the contract."""

from components.allocator import plain
from components.allocator.commands import write_commands
from components.allocator.unlimited import lay_out, sizes, solve_quadratic
from components.compiled import kernel
from components.contract import HEADER, Component


@kernel
def allocate(p, u, x, y, w):
    """Allocate the demand."""
    is_solved = solve_quadratic(p, u, w)
    thrusters, f, _, _, _, _, _ = lay_out(p, w)
    write_commands(thrusters, f, x, y, 1.0 if is_solved else 0.0)
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
    name="allocator.quadratic",
    parameters=plain.Plain,
    inputs=plain.inputs,
    outputs=plain.outputs,
    sizes=sizes,
    init=init,
    step=step,
    assumptions="A cost of a T^2 with the a of T^(3/2), and no limits: thrusters may be asked for more than they have, "
    "in any direction. van Daalen et al. 2011, eqs. 11 to 15.",
)
