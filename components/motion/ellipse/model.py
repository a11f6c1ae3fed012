"""A point going round an ellipse, a circle or to and fro on a line: its parameters and port."""

from components.contract import Parameters, Port, Term, motion_ports, quantity


class Ellipse(Parameters):
    """centre + r(t) (cosine cos(2 pi f t) + sine sin(2 pi f t)), where r grows smoothly from 0 at t0 to 1.

    A circle where both semi-axes are of one length and perpendicular; a straight oscillation where one is zero.
    """

    centre: tuple[float, float, float] = quantity("m", "centre of the ellipse, NED; where the point is at t0")
    cosine: tuple[float, float, float] = quantity("m", "semi-axis that goes with the cosine, NED", (0.0, 0.0, 0.0))
    sine: tuple[float, float, float] = quantity("m", "semi-axis that goes with the sine, NED", (0.0, 0.0, 0.0))
    frequency: float = quantity("Hz", "rounds per second", ge=0)
    ramp: float = quantity("s", "time that the semi-axes take to grow to their length", gt=0)


def outputs(_: Ellipse) -> tuple[Port, ...]:
    """The point's motion."""
    return motion_ports("motion")


def terms(ellipse: Ellipse) -> tuple[Term, ...]:
    """What of the model is on."""
    moves = ellipse.frequency > 0.0
    still = "" if moves else ", frequency is 0 Hz"
    c, s = (", ".join(f"{number:g}" for number in axis) for axis in (ellipse.cosine, ellipse.sine))
    return (
        Term("with the cosine", any(ellipse.cosine), f"cosine ({c}) m{still}"),
        Term("with the sine", moves and any(ellipse.sine), f"sine ({s}) m{still}"),
    )
