"""Messages with points as frames of markers: by the points' ids where they tell, else by their order in the list."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np

from pipeline.errors import LogError
from pipeline.quantities import shown

_NUMBERED = re.compile(r"(?P<prefix>.*?)(?P<number>\d{1,9})")
MOST_IDS = 3  # times the points of any message: a tracker that gives an id anew each time a marker comes back


@dataclass
class Messages:
    """Times [ns], points (x, y, z) and ids of the messages so far; an empty list of points is a frame without any."""

    times: list[int] = field(default_factory=list)
    points: list[list[list[float]]] = field(default_factory=list)
    ids: list[list[str] | None] = field(default_factory=list)
    places: list[str] = field(default_factory=list)

    def add(self, t_ns: int, points: list[list[float]], ids: list[str] | None, at: str) -> None:
        """One more message; at: its name in messages to the user."""
        self.times.append(t_ns)
        self.points.append(points)
        self.ids.append(ids)
        self.places.append(at)

    def position(self, name: str) -> np.ndarray:
        """(k, m, 3) [m], NaN where not seen. Raises LogError where it is not known which marker is which."""
        full = [i for i, points in enumerate(self.points) if points]
        return self._by_id(full, name) if self._have_ids(full) else self._by_place(full)

    def _have_ids(self, full: list[int]) -> bool:
        """Whether points are told apart by ids: not by such as are alike (protobuf's zeros), or names in one order."""
        first = self.ids[full[0]]
        named = [one for one in first or () if one]
        if first is None or len(named) != len(set(named)):
            return False
        return all(_NUMBERED.fullmatch(one) for one in named) or any(self.ids[i] != first for i in full)

    def _by_place(self, full: list[int]) -> np.ndarray:
        count = len(self.points[full[0]])
        found = np.full((len(self.times), count, 3), np.nan)
        for i in full:
            if len(self.points[i]) != count:
                raise LogError(
                    f"{self.places[i]}: {len(self.points[i])} points, {count} before: which marker is which is not "
                    "known; give each point an id, or null where a marker was not seen"
                )
            found[i] = self.points[i]
        return found

    def _by_id(self, full: list[int], name: str) -> np.ndarray:
        for i in full:
            named = [one for one in self.ids[i] or () if one]
            if self.ids[i] is None:
                raise LogError(f"{self.places[i]}: points without an id, which those before have")
            if len(named) != len(set(named)):
                twice = next(one for one in named if named.count(one) > 1)
                raise LogError(f"{self.places[i]}: {named.count(twice)} points have the id {shown(twice)}")
        number = self._numbers(full)
        most = max(len(self.points[i]) for i in full)
        if len(number) > MOST_IDS * most:
            raise LogError(
                f"{name}: {len(number)} different ids, but at most {most} points in a message: the ids do not tell the "
                "markers' places on the line"
            )
        column = {one: place for place, one in enumerate(sorted(number, key=number.__getitem__))}
        found = np.full((len(self.times), len(column), 3), np.nan)
        for i in full:
            for one, point in zip(self.ids[i] or (), self.points[i], strict=True):
                if one:
                    found[i, column[one]] = point
        return found

    def _numbers(self, full: list[int]) -> dict[str, int]:
        """The number at the end of each id. Raises LogError where ids do not tell the order along one line."""
        found, prefixes = {}, {}
        for i in full:
            for one in self.ids[i] or ():
                parts = _NUMBERED.fullmatch(one)
                if one and parts is None:
                    raise LogError(
                        f"{self.places[i]}: the id {shown(one)} does not end with the marker's number on the line"
                    )
                if parts is not None and one not in found:
                    found[one] = int(parts["number"])
                    prefixes[parts["prefix"]] = one
        if len(prefixes) > 1 or len(set(found.values())) < len(found):
            some = ", ".join(list(prefixes.values() if len(prefixes) > 1 else found)[:4])
            raise LogError(
                f"{self.places[full[0]]}: ids such as {some} do not tell one line's order; write a channel a line"
            )
        return found
