"""A winch drum: speed command, limits of speed, acceleration and pull, and the line that it holds."""

from components.contract import Parameters, Port, Sizes, Term, choice, quantity


class Drum(Parameters):
    """Paying out counts positive. The commanded speed is the parameter's plus the input's."""

    speed: float = quantity("m/s", "commanded payout rate", 0.0, tunable=True)
    max_speed: float = quantity("m/s", "largest rate, both ways, without load", gt=0)
    max_acceleration: float = quantity("m/s^2", "largest change of the rate", gt=0)
    stall_tension: float = quantity(
        "N",
        "at this tension hauling in stops, and above it the drum slips: rate >= max_speed (tension / this - 1)",
        gt=0,
    )
    stored: float = quantity("m", "line on the drum at t0", gt=0)
    commanded: bool = choice("whether another component commands a rate", False)


def inputs(drum: Drum) -> tuple[Port, ...]:
    """The line's tension at the drum, and the command if there is one."""
    tension = (Port("tension", "N", (), "", "of the line at the drum"),)
    return tension + ((Port("command", "m/s", (), "", "payout rate asked for"),) if drum.commanded else ())


def outputs(_: Drum) -> tuple[Port, ...]:
    """The rate that the line is paid out at, what is left, and the power that the drum gives to the line."""
    return (
        Port("payout_rate", "m/s", (), "", "unstretched length per time let out"),
        Port("stored", "m", (), "", "line on the drum"),
        Port("power", "W", (), "", "of the drum on the line: hauling in against the tension"),
    )


def sizes(_: Drum) -> Sizes:
    """Rate and stored line."""
    return Sizes(state=2)


def terms(drum: Drum) -> tuple[Term, ...]:
    """What of the model is on."""
    return (
        Term("constant speed", drum.speed != 0.0, f"speed {drum.speed:g} m/s"),
        Term("command from outside", drum.commanded, f"commanded is {str(drum.commanded).lower()}"),
    )
