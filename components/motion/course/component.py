"""Binds the course to the contract: a function of time alone."""

from components.contract import HEADER, Component
from components.motion.course import model
from components.motion.course.pieces import at_time

ORIGIN, COUNT, FIRST = HEADER, HEADER + 3, HEADER + 4


def step(t_ns, dt_ns, p, u, x, y, w):
    """Where the vessel is at t_ns."""
    at_time(t_ns, p, FIRST, int(p[COUNT]), y)
    for i in range(3):
        y[i] += p[ORIGIN + i]
    return 0


COMPONENT = Component(
    name="motion.course",
    parameters=model.Course,
    outputs=model.outputs,
    init=step,
    step=step,
    terms=model.terms,
    assumptions="The line does not move the vessel.",
)
