"""Charts as data: what a page's plotter draws, thinned to what a screen can show."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

SPANS = 1000  # of a curve, each drawn by its extremes: more than a figure has pixels
EXTREMES = ((np.argmin, np.inf), (np.argmax, -np.inf))
TIME = "time [s]"


@dataclass(frozen=True)
class Window:
    """The part of a record that is drawn [s]."""

    start: float
    end: float


@dataclass(frozen=True)
class Series:
    """A curve: t (k,) [s], values (k,), NaN where not known. kind: line, step (held until the next) or dots.

    faint: drawn grey, behind the others.
    """

    name: str
    t: np.ndarray
    values: np.ndarray
    kind: str = "line"
    faint: bool = False


@dataclass(frozen=True)
class Chart:
    """A figure over time. axis: title and unit of what is drawn; limits: levels with names, dashed.

    bands: spans of time [s] shaded as failing. lanes: instead of curves, by name, the spans [s] in which it is so.
    """

    title: str
    axis: str
    series: Sequence[Series] = ()
    caption: str = ""
    log: bool = False
    limits: Sequence[tuple[float, str]] = ()
    bands: Sequence[tuple[float, float]] = ()
    lanes: Sequence[tuple[str, list[tuple[float, float]]]] = field(default=())

    def as_json(self) -> dict[str, Any]:
        """As the page's plotter reads it."""
        return {
            "title": self.title,
            "x": TIME,
            "y": self.axis,
            "log": self.log,
            "limits": [{"value": value, "name": name} for value, name in self.limits],
            "bands": [[round(a, 4), round(b, 4)] for a, b in self.bands],
            "lanes": [
                {"name": name, "spans": [[round(a, 3), round(b, 3)] for a, b in found]} for name, found in self.lanes
            ],
            "series": [_curve(one) for one in self.series],
        }


def _curve(series: Series) -> dict[str, Any]:
    t, values = thinned(np.asarray(series.t, float), np.asarray(series.values, float).reshape(len(series.t)))
    return {
        "name": series.name,
        "kind": series.kind,
        "faint": series.faint,
        "t": encoded(t, "<f4"),
        "v": encoded(values, "<f4"),
    }


def encoded(numbers: np.ndarray, kind: str) -> str:
    """Base64 of numbers in this little-endian type."""
    return b64encode(np.ascontiguousarray(numbers, kind).tobytes()).decode()


def thinned(t: np.ndarray, values: np.ndarray, spans: int = SPANS) -> tuple[np.ndarray, np.ndarray]:
    """The least and the greatest value of each of many spans of equal length, in order of time; NaN where all are.

    t, values: (k,). Curves of at most 4 points a span are returned as they are.
    """
    count = len(t) // spans
    if count < 4:
        return t, values
    edge = count * (len(t) // count)
    parts = values[:edge].reshape(-1, count)
    least, greatest = (pick(np.where(np.isnan(parts), fill, parts), axis=1) for pick, fill in EXTREMES)
    index = np.sort(np.stack([least, greatest], axis=1), axis=1) + count * np.arange(len(parts))[:, None]
    kept = np.concatenate([index.ravel(), np.arange(edge, len(t))])
    return t[kept], values[kept]


def when(t: np.ndarray, is_so: np.ndarray) -> list[tuple[float, float]]:
    """The spans of time [s] in which it is so: t, is_so (k,). Gaps that no screen shows are closed."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], is_so, [False]]).astype(np.int8)))
    if not len(edges):
        return []
    starts, ends = t[edges[::2]], t[np.minimum(edges[1::2], len(t) - 1)]
    apart = np.flatnonzero(starts[1:] - ends[:-1] > (t[-1] - t[0]) / SPANS)
    return list(zip(starts[np.insert(apart + 1, 0, 0)].tolist(), ends[np.append(apart, -1)].tolist(), strict=True))
