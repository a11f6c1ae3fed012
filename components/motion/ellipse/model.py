"""A point going round an ellipse, a circle or to and fro on a line: its parameters and port."""

from components.contract import Parameters, Port, motion_ports, quantity


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
