"""Gives out what it saw: shows which value of a signal reached it, and optionally stops the run at a value."""

from components.contract import HEADER, Component, Parameters, Port, choice, quantity


class Relay(Parameters):
    """width: numbers seen; stop_at: seeing this first number gives status 1; poison_at: it gives NaN."""

    width: int = choice("numbers in and out", 1)
    stop_at: float = quantity("1", "first number that stops the run", 1e300)
    poison_at: float = quantity("1", "first number that makes the output NaN", 1e300)


def see(t_ns, dt_ns, p, u, x, y, w):
    for i in range(len(y)):
        y[i] = u[i]
    if u[0] == p[HEADER + 2]:
        y[len(y) - 1] = float("nan")
    return 1 if u[0] == p[HEADER + 1] else 0


def ports(name):
    def of(relay):
        return (Port(name, "1", (relay.width,) if relay.width > 1 else ()),)

    return of


COMPONENT = Component(
    name="relay",
    parameters=Relay,
    inputs=ports("in"),
    outputs=ports("out"),
    init=see,
    step=see,
    status_text={1: "it saw the number it was told to stop at"},
)
