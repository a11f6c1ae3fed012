"""Van der Pol oscillators coupled in a ring: the smallest component that is worth timing."""

from components.contract import Parameters, Port, Sizes, Term, quantity


class VanDerPol(Parameters):
    """x'' = mu (1 - x^2) x' - x + kappa (neighbour - x), in dimensionless time of 1 s."""

    mu: float = quantity("1", "nonlinearity", 1.0, tunable=True, ge=0)
    coupling: float = quantity("1", "kappa, strength of the spring to the neighbour", 0.1, tunable=True)
    position: float = quantity("1", "x at t0", 2.0)
    velocity: float = quantity("1/s", "x' at t0", 0.0)


def inputs(_: VanDerPol) -> tuple[Port, ...]:
    """The neighbour's position."""
    return (Port("neighbour", "1"),)


def outputs(_: VanDerPol) -> tuple[Port, ...]:
    """Position and velocity."""
    return (Port("position", "1"), Port("velocity", "1/s"))


def sizes(_: VanDerPol) -> Sizes:
    """Two states."""
    return Sizes(state=2)


def terms(oscillator: VanDerPol) -> tuple[Term, ...]:
    """What of the model is on."""
    return (
        Term("nonlinear damping", oscillator.mu > 0.0, f"mu {oscillator.mu:g}"),
        Term("coupling", oscillator.coupling != 0.0, f"coupling {oscillator.coupling:g}"),
    )
