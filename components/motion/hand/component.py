"""Binds the hand to the contract: a function of time, parameters and seed alone."""

from components.compiled import kernel
from components.contract import HEADER, SEED_HIGH, SEED_LOW, Component
from components.motion.hand import model
from components.motion.hand.programme import last_before, meant, unsteadiness
from components.motion.hand.spline import CONTROLS, acceleration, position, velocity
from components.motion.hand.track import PIECE, quintic

HAS_TABLE, KNOT_NS, TREMOR, CENTRE = HEADER, HEADER + 1, HEADER + 2, HEADER + 3
COUNT, END_NS, FIRST = HEADER + 6, HEADER + 7, HEADER + 8


@kernel
def write_controls(p, last, w):
    """The control points last - 5 ... last of all axes into w (3, 6); up to number 0 the hand is at home."""
    for k in range(CONTROLS):
        j = last - (CONTROLS - 1) + k
        north = east = down = 0.0
        if j > 0:
            north, east, down = meant(p, FIRST, int(p[COUNT]), (j * int(p[KNOT_NS])) % int(p[END_NS]))
            if p[TREMOR] > 0.0:
                a, b, c = unsteadiness(p[SEED_HIGH], p[SEED_LOW], j)
                north, east, down = north + p[TREMOR] * a, east + p[TREMOR] * b, down + p[TREMOR] * c
        w[k] = north
        w[CONTROLS + k] = east
        w[2 * CONTROLS + k] = down


@kernel
def follow_programme(t_ns, p, y, w):
    """The spline at t_ns; it reads the programme up to the last knot, so the hand lags by three of them."""
    knot_ns = int(p[KNOT_NS])
    last = t_ns // knot_ns
    f = (t_ns - last * knot_ns) / knot_ns
    rate = 1e9 / knot_ns
    write_controls(p, last, w)
    for i in range(3):
        c = CONTROLS * i
        y[i] = p[CENTRE + i] + position(w[c], w[c + 1], w[c + 2], w[c + 3], w[c + 4], w[c + 5], f)
        y[3 + i] = rate * velocity(w[c], w[c + 1], w[c + 2], w[c + 3], w[c + 4], w[c + 5], f)
        y[6 + i] = rate * rate * acceleration(w[c], w[c + 1], w[c + 2], w[c + 3], w[c + 4], w[c + 5], f)


@kernel
def follow_table(t_ns, p, y):
    """The track at t_ns, at rest before its first row and after its last."""
    within_ns = min(max(t_ns, int(p[FIRST])), int(p[END_NS]))
    at = FIRST + PIECE * last_before(p, FIRST, PIECE, int(p[COUNT]), within_ns)
    seconds = (within_ns - int(p[at])) * 1e-9
    moves = within_ns == t_ns
    for i in range(3):
        x, v, a = quintic(p, at + 1 + 6 * i, seconds)
        y[i] = p[CENTRE + i] + x
        y[3 + i] = v if moves else 0.0
        y[6 + i] = a if moves else 0.0


def step(t_ns, dt_ns, p, u, x, y, w):
    """Where the hand is at t_ns."""
    if p[HAS_TABLE] > 0.0:
        follow_table(t_ns, p, y)
    else:
        follow_programme(t_ns, p, y, w)
    return 0


COMPONENT = Component(
    name="motion.hand",
    parameters=model.Hand,
    outputs=model.outputs,
    sizes=model.sizes,
    init=step,
    step=step,
    terms=model.terms,
    assumptions="The line does not move the hand; a stick in water is not moved faster than about 1 m/s for long.",
)
