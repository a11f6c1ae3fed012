"""Points of a floating rope seen from a boat: parameters, ports and sizes."""

from __future__ import annotations

from math import pi
from typing import Annotated

from pydantic import Field, model_validator

from components.contract import Parameters, Port, Sizes, Term, choice, quantity


class RopeView(Parameters):
    """A camera over the water whose picture's points are mapped to the boat's frame, as Bhattacharya et al. 2011, V."""

    segments: Annotated[int, Field(ge=3)] = choice("number of equal segments of the line that is wired to nodes")
    points: Annotated[int, Field(ge=1, le=1000)] = choice(
        "equally spaced along the line, each in its cell's middle", 40
    )
    camera: tuple[float, float] = quantity("m", "place ahead of the boat's origin, and to starboard", (0.0, 0.0))
    bearing: float = quantity("rad", "of the middle of what is seen, from ahead to starboard", pi)
    field: float = quantity("rad", "opening angle of what is seen", pi, gt=0, le=2.0 * pi)
    nearest: float = quantity("m", "from the camera that is seen", 0.0, ge=0)
    farthest: float = quantity("m", "from the camera that is seen", gt=0)
    noise: float = quantity("m", "standard deviation of a point along each axis", 0.0, tunable=True, ge=0)
    noise_per_range: float = quantity(
        "1", "more of it, independent, over the distance from the camera", 0.0, tunable=True, ge=0
    )

    @model_validator(mode="after")
    def _sees_something(self) -> RopeView:
        if self.nearest >= self.farthest:
            raise ValueError(f"nearest is {self.nearest:g} m, farthest {self.farthest:g} m: nothing would be seen")
        return self


def inputs(view: RopeView) -> tuple[Port, ...]:
    """The line's nodes, and where the boat really is."""
    return (
        Port("nodes", "m", (view.segments + 1, 3), "NED", "node positions from end a to end b"),
        Port("position", "m", (2,), "NED", "of the boat's origin"),
        Port("heading", "rad", (), "NED", "of the boat"),
    )


def outputs(view: RopeView) -> tuple[Port, ...]:
    """What the picture gives at the end of the step."""
    return (
        Port("points", "m", (view.points, 2), "body", "ahead and to starboard of the boat; zero where not valid"),
        Port("valid", "1", (view.points,), "", "1 where the point is seen, else 0"),
    )


def sizes(_: RopeView) -> Sizes:
    """How many pictures were taken."""
    return Sizes(state=1)


def terms(view: RopeView) -> tuple[Term, ...]:
    """What of the model is on."""
    noisy = view.noise > 0.0 or view.noise_per_range > 0.0
    return (Term("noise", noisy, f"noise {view.noise:g} m and {view.noise_per_range:g} of the distance"),)
