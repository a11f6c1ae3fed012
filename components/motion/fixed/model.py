"""A point at rest in the world, such as the anchored end of a line."""

from components.contract import Parameters, Port, motion_ports, quantity


class Fixed(Parameters):
    """Where the point is."""

    position: tuple[float, float, float] = quantity("m", "position in the world, NED")


def outputs(_: Fixed) -> tuple[Port, ...]:
    """The point's motion: its position, and zeros."""
    return motion_ports("motion")
