"""Binds the control of a towed line's shape to the contract."""

from components.compiled import kernel
from components.contract import HEADER, Component
from components.controller.shape import model
from components.controller.shape.law import read_angles, steer
from components.controller.shape.layout import EDGE, PLACE, SEGMENTS, TARGET, VELOCITY
from components.kinematics import wrapped
from components.matrices import table

MOTION = 9


@kernel
def decide(q, u, w):
    """Write the ends' velocities to the last four of w; largest error, and whether they are limited."""
    n = int(q[SEGMENTS])
    theta, wanted = w[:n], w[n : 2 * n]
    read_angles(table(u, 0, n + 1, 3), theta)
    at = 2 * n
    drag, sides = table(w, at, n, n), table(w, at + n * n, n, EDGE)
    at += n * n + EDGE * n
    rates, system = table(w, at, n, EDGE), table(w, at + EDGE * n, EDGE, EDGE + 1)
    return steer(q, theta, wanted, drag, sides, rates, system, w[len(w) - EDGE :])


@kernel
def write(q, u, x, h, w, largest, is_limited, y):
    """Move the ends and write all outputs; h: the step [s], nothing moves where it is zero."""
    n = int(q[SEGMENTS])
    velocity = w[len(w) - EDGE :]
    for end in range(2):
        for k in range(2):
            j = 2 * end + k
            before, after = x[VELOCITY + j], velocity[j] if h > 0.0 else 0.0
            x[PLACE + j] += 0.5 * h * (before + after)
            x[VELOCITY + j] = after
            y[MOTION * end + k], y[MOTION * end + 3 + k] = x[PLACE + j], after
            y[MOTION * end + 6 + k] = (after - before) / h if h > 0.0 else 0.0
        y[MOTION * end + 2] = u[2] if end == 0 else u[3 * n + 2]
        y[MOTION * end + 5] = y[MOTION * end + 8] = 0.0
    for i in range(n):
        y[2 * MOTION + i] = wrapped(q[TARGET + i] - w[i])
    y[2 * MOTION + n], y[2 * MOTION + n + 1] = largest, is_limited


def init(t_ns, dt_ns, p, u, x, y, w):
    """Begin with the ends where they are, at rest."""
    q = p[HEADER:]
    n = int(q[SEGMENTS])
    x[PLACE], x[PLACE + 1], x[PLACE + 2], x[PLACE + 3] = u[0], u[1], u[3 * n], u[3 * n + 1]
    for j in range(EDGE):
        x[VELOCITY + j] = 0.0
    largest, is_limited = decide(q, u, w)
    write(q, u, x, 0.0, w, largest, is_limited, y)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """Move the ends by the law."""
    q = p[HEADER:]
    largest, is_limited = decide(q, u, w)
    write(q, u, x, dt_ns * 1e-9, w, largest, is_limited, y)
    return 0


COMPONENT = Component(
    name="controller.shape",
    parameters=model.Shape,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    assumptions="The line has equal rigid segments without inertia, and linear drag; boats go where they are told; "
    "with more than four segments not every shape can be reached.",
)
