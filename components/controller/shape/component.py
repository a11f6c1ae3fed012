"""Binds the control of a towed line's shape to the contract."""

from components.compiled import kernel
from components.contract import HEADER, Component
from components.controller.shape import model
from components.controller.shape.law import read_angles, steer
from components.controller.shape.layout import (
    EDGE,
    HORIZON,
    KNOTS,
    PLACE,
    PLAN,
    PLAN_DAMPING,
    SEGMENTS,
    STEPS,
    TARGET,
    VELOCITY,
)
from components.controller.shape.planning import FIRST, planned, replan
from components.kinematics import wrapped
from components.matrices import table

MOTION = 9


@kernel
def decide(q, u, x, w, h):
    """Write the ends' velocities to w[:4]; largest error, and whether the law's are limited. h: step [s], or 0."""
    n = int(q[SEGMENTS])
    theta, wanted = w[EDGE : EDGE + n], w[EDGE + n : EDGE + 2 * n]
    read_angles(table(u, 0, n + 1, 3), theta)
    at = EDGE + 2 * n
    drag, sides = table(w, at, n, n), table(w, at + n * n, n, EDGE)
    at += n * n + EDGE * n
    rates, system = table(w, at, n, EDGE), table(w, at + EDGE * n, EDGE, EDGE + 1)
    at += EDGE * n + EDGE * (EDGE + 1)
    largest, is_limited = steer(q, theta, wanted, drag, sides, rates, system, w[:EDGE])
    if q[HORIZON] > 0.0 and h > 0.0:
        steps, many = int(q[STEPS]), EDGE * int(q[KNOTS])
        moving, at = w[at : at + n], at + n
        ways, at = table(w, at, many + 2, steps * n), at + (many + 2) * steps * n
        normal, step = table(w, at, many, many), table(w, at + many * many, many, 1)
        at += many * many
        plan, trial, kept = x[PLAN : PLAN + many], w[at : at + many], w[at + many : at + 2 * many]
        x[PLAN_DAMPING], law_is_better = replan(
            q, theta, plan, x[PLAN_DAMPING], h, ways, normal, step, trial, kept, moving, wanted, drag, sides, rates,
            system, w[:EDGE],
        )  # fmt: skip
        if law_is_better:
            steer(q, theta, wanted, drag, sides, rates, system, w[:EDGE])
        else:
            planned(q, plan, 0.5 * h / q[HORIZON], w[:EDGE])
    return largest, is_limited


@kernel
def write(q, u, x, h, w, largest, is_limited, y):
    """Move the ends and write all outputs; h: the step [s], nothing moves where it is zero."""
    n = int(q[SEGMENTS])
    for end in range(2):
        for k in range(2):
            j = 2 * end + k
            before, after = x[VELOCITY + j], w[j] if h > 0.0 else 0.0
            x[PLACE + j] += 0.5 * h * (before + after)
            x[VELOCITY + j] = after
            y[MOTION * end + k], y[MOTION * end + 3 + k] = x[PLACE + j], after
            y[MOTION * end + 6 + k] = (after - before) / h if h > 0.0 else 0.0
        y[MOTION * end + 2] = u[2] if end == 0 else u[3 * n + 2]
        y[MOTION * end + 5] = y[MOTION * end + 8] = 0.0
    for i in range(n):
        y[2 * MOTION + i] = wrapped(q[TARGET + i] - w[EDGE + i])
    y[2 * MOTION + n], y[2 * MOTION + n + 1] = largest, is_limited


def init(t_ns, dt_ns, p, u, x, y, w):
    """Begin with the ends where they are, at rest."""
    q = p[HEADER:]
    n = int(q[SEGMENTS])
    x[PLACE], x[PLACE + 1], x[PLACE + 2], x[PLACE + 3] = u[0], u[1], u[3 * n], u[3 * n + 1]
    for j in range(VELOCITY, len(x)):
        x[j] = 0.0
    x[PLAN_DAMPING] = FIRST
    largest, is_limited = decide(q, u, x, w, 0.0)
    write(q, u, x, 0.0, w, largest, is_limited, y)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """Move the ends by the law."""
    q = p[HEADER:]
    largest, is_limited = decide(q, u, x, w, dt_ns * 1e-9)
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
    terms=model.terms,
    assumptions="The line has equal rigid segments without inertia, and linear drag; boats go where they are told; "
    "with more than four segments not every shape can be reached.",
)
