"""Markers on a line seen by a motion-capture system: parameters, ports and sizes."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from components.contract import Parameters, Port, Sizes, Term, choice, quantity

ROUNDING = 1e-9  # of the length: eleven spacings of 0.245 m may reach 2.695 m by a rounding, and no further


class Tracker(Parameters):
    """Equally spaced markers, the last one on or near end b; Drupt et al. 2022, Table I, gives count and spacing.

    In their figure 5 the mobile end has index 12 of 12 markers, in figure 7 index 8 of 9: this model takes the second
    as counted from 0, so that in both the last marker sits on the mobile end (offset 0).
    """

    length: float = quantity("m", "unstretched length of the line", gt=0)
    segments: Annotated[int, Field(ge=3)] = choice("number of equal segments of the line that is wired to nodes")
    markers: Annotated[int, Field(ge=1)] = choice("number of markers")
    spacing: float = quantity("m", "distance of two markers along the unstretched line", gt=0)
    offset: float = quantity("m", "distance of the last marker from end b along the line", 0.0, ge=0)
    noise: float = quantity("m", "standard deviation of a tracked position along each axis", 0.0, tunable=True, ge=0)
    visible_time: float = quantity("s", "mean time that a marker stays visible", 1.0, tunable=True, gt=0)
    lost_time: float = quantity("s", "mean time that a lost one stays lost; 0: none is lost", 0.0, tunable=True, ge=0)

    @model_validator(mode="after")
    def _markers_are_on_the_line(self) -> Tracker:
        reach = self.offset + (self.markers - 1) * self.spacing
        if reach > self.length * (1.0 + ROUNDING):
            raise ValueError(
                f"the first of {self.markers} markers would be {reach:g} m from end b of a line of {self.length:g} m: "
                "expected fewer markers, a smaller spacing or a smaller offset"
            )
        return self


def inputs(tracker: Tracker) -> tuple[Port, ...]:
    """The line's nodes, equally spaced along the unstretched line."""
    return (Port("nodes", "m", (tracker.segments + 1, 3), "NED", "node positions from end a to end b"),)


def outputs(tracker: Tracker) -> tuple[Port, ...]:
    """What the cameras give at the end of the step."""
    return (
        Port("position", "m", (tracker.markers, 3), "NED", "of the markers, from end a to end b; zero where not valid"),
        Port("valid", "1", (tracker.markers,), "", "1 where the marker is seen, else 0"),
    )


def sizes(tracker: Tracker) -> Sizes:
    """How many frames were taken, and which markers are lost."""
    return Sizes(state=1 + tracker.markers)


def terms(tracker: Tracker) -> tuple[Term, ...]:
    """What of the model is on."""
    lost = f"lost for {tracker.lost_time:g} s after {tracker.visible_time:g} s in the mean" if tracker.lost_time else ""
    return (
        Term("noise", tracker.noise > 0.0, f"noise {tracker.noise:g} m"),
        Term("loss of markers", tracker.lost_time > 0.0, lost or "lost_time is 0"),
    )
