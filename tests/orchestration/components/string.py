"""The line's side of a power bond, without physics: it never pulls. Its laws are there only when it is bonded."""

from components.contract import N_Y, Component, LineEnd, Parameters, Port, choice, law_ports, motion_ports


class String(Parameters):
    """The switches of its two ends."""

    bond_a: bool = choice("whether end a is bonded", False)
    bond_b: bool = choice("whether end b is bonded", False)


def inputs(_: String) -> tuple[Port, ...]:
    return motion_ports("end_a") + motion_ports("end_b")


def outputs(string: String) -> tuple[Port, ...]:
    ports = (Port("tension", "N"),)
    for end, bonded in (("a", string.bond_a), ("b", string.bond_b)):
        if bonded:
            ports += law_ports(f"law_{end}") + law_ports(f"accepted_{end}")
    return ports


def step(t_ns, dt_ns, p, u, x, y, w):
    for i in range(int(p[N_Y])):
        y[i] = 0.0
    return 0


def _end(name: str) -> LineEnd:
    return LineEnd(f"end_{name}", f"force_{name}", f"law_{name}", f"accepted_{name}", f"bond_{name}", lambda _: 1.0)


COMPONENT = Component(
    name="test.string",
    parameters=String,
    inputs=inputs,
    outputs=outputs,
    init=step,
    step=step,
    lines={"end_a": _end("a"), "end_b": _end("b")},
)
