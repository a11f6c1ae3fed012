"""What is known of a steady tow at some instants: the ends, the tow's direction, points of the line, pulls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Errors:
    """Standard deviations of a boat's position, each axis [m], and heading [rad], as its own instruments give them.

    each: new in each picture; bias: the same in all of them.
    """

    position_each: float = 0.0
    heading_each: float = 0.0
    position_bias: float = 0.0
    heading_bias: float = 0.0

    def any(self) -> bool:
        """Whether there are any."""
        return bool(self.each().any() or self.bias().any())

    def each(self) -> np.ndarray:
        """(6,) for north, east, heading of both boats."""
        return np.array([self.position_each, self.position_each, self.heading_each] * 2)

    def bias(self) -> np.ndarray:
        """(6,) likewise."""
        return np.array([self.position_bias, self.position_bias, self.heading_bias] * 2)


@dataclass(frozen=True)
class Pictures:
    """k pictures of a line of `length` [m] that two boats tow, in steady tow.

    pose: (k, 2, 3) north, east [m] and heading [rad] of the boats. hook: where both hold the line, ahead and to
    starboard [m]. heading: (k,) of the tow through the water [rad]; speed: (k,) [m/s]. points: (k, 2, m, 2) ahead and
    to starboard of each boat [m]; deviation: (k, 2, m) of each, each axis [m], infinite where there is none.
    pull: (k, 2) forces at both ends [N], NaN where not measured; pull_error: part of them that is their deviation.
    """

    length: float
    pose: np.ndarray
    hook: tuple[float, float]
    heading: np.ndarray
    speed: np.ndarray
    points: np.ndarray
    deviation: np.ndarray
    pull: np.ndarray
    pull_error: float = 0.0

    def placed(self, moved: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Ends (k, 2, 2) and points (k, 2, m, 2) across and along the tow, the boats moved by (6,) or (k, 6)."""
        pose = self.pose + np.broadcast_to(moved, (len(self.pose), 6)).reshape(-1, 2, 3)
        co, si = np.cos(pose[..., 2]), np.sin(pose[..., 2])
        at = pose[..., :2] + np.stack(
            [co * self.hook[0] - si * self.hook[1], si * self.hook[0] + co * self.hook[1]], axis=-1
        )
        co, si = co[..., None], si[..., None]
        ahead, aside = self.points[..., 0], self.points[..., 1]
        north, east = co * ahead - si * aside, si * ahead + co * aside
        points = np.stack([north, east], axis=-1) + pose[:, :, None, :2]
        return self._across(at), self._across(points)

    def _across(self, places: np.ndarray) -> np.ndarray:
        """North and east as across (to starboard) and along the tow."""
        shape = (len(self.heading), *[1] * (places.ndim - 2))
        co, si = np.cos(self.heading).reshape(shape), np.sin(self.heading).reshape(shape)
        north, east = places[..., 0], places[..., 1]
        return np.stack([co * east - si * north, co * north + si * east], axis=-1)
