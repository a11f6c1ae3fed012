"""A model with a validity range and a term: its validity is a tenth of the seconds, at t0 zero."""

from components.contract import HEADER, Component, Parameters, Port, Sizes, Term, quantity


class Ranged(Parameters):
    """One term, on where `drag` is positive."""

    drag: float = quantity("1", "of the term", 0.0, ge=0)


def init(t_ns, dt_ns, p, u, x, y, w):
    x[0] = 0.0
    y[0], y[1], y[2] = 0.0, 0.0, 0.0
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    x[0] += 1.0
    y[0] = 0.1 * x[0]
    y[1] = 0.05 * x[0]
    y[2] = 0.1 * x[0] + p[HEADER]
    return 0


COMPONENT = Component(
    name="ranged",
    parameters=Ranged,
    outputs=lambda _: (Port("validity.strain", "1"), Port("validity.slope", "1"), Port("validity.range", "1")),
    sizes=lambda _: Sizes(state=1),
    init=init,
    step=step,
    terms=lambda ranged: (Term("drag", ranged.drag > 0.0, f"drag is {ranged.drag:g}"),),
    validity="validity.range",
    assumptions="Ten seconds.",
)
