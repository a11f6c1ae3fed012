"""The water that a line really swept: the union of what lies between its successive shapes."""

from __future__ import annotations

import numpy as np
import shapely

from pipeline.errors import TowlineError
from pipeline.log.reader import Log

LEAST = 1e-14  # of the square of the track's size: areas of quadrilaterals that rounding makes, and that are left out


def swept(shapes: np.ndarray) -> shapely.Geometry:
    """What the line went over: shapes (k, n + 1, 2) north and east [m], in order of time.

    Each part of the line sweeps the quadrilateral between its place in one shape and in the next; of one that crosses
    itself, as where a part turns about a point of itself, both lobes. Where it went twice, it counts once. Of second
    order in the time between shapes, for a part that turns as it goes.
    """
    return shapely.union_all(_between(shapes))


def area(shapes: np.ndarray) -> float:
    """Of what the line went over [m^2]."""
    return float(shapely.area(swept(shapes)))


def _between(shapes: np.ndarray) -> np.ndarray:
    """Valid polygons between each two shapes: one of a step whose parts all sweep to one side, else each part's."""
    here, there = shapes[:-1], shapes[1:]
    corners = np.stack([here[:, :-1], here[:, 1:], there[:, 1:], there[:, :-1], here[:, :-1]], axis=2)
    x, y = corners[..., 0], corners[..., 1]
    side = np.sign((x[..., :-1] * y[..., 1:] - x[..., 1:] * y[..., :-1]).sum(axis=2))
    strips = np.asarray(shapely.polygons(np.concatenate([here, there[:, ::-1], here[:, :1]], axis=1)))
    plain = (np.abs(side.sum(axis=1)) == side.shape[1]) & shapely.is_valid(strips)
    parts = np.asarray(shapely.polygons(corners[~plain].reshape(-1, 5, 2)))
    crossed = ~shapely.is_valid(parts)
    parts[crossed] = shapely.make_valid(parts[crossed], method="structure", keep_collapsed=False)
    size = np.ptp(shapes.reshape(-1, 2), axis=0).max()
    return np.concatenate([strips[plain], parts[shapely.area(parts) > LEAST * size * size]])


def line_shapes(log: Log, line: str | None, drift: tuple[float, float]) -> tuple[str, np.ndarray, np.ndarray]:
    """The line's channel, its times (k,) [s] and its shapes (k, n + 1, 2), as seen from water that drifts [m/s].

    line: None for the only channel that has nodes. Raises TowlineError where there is none, or several.
    """
    found = [name for name, channel in log.channels.items() if any(port.name == "nodes" for port in channel.ports)]
    if line is None and len(found) != 1:
        what = f"has {len(found)} lines ({', '.join(found)})" if found else "has no line"
        raise TowlineError(f"{log.path} {what}; give --line NAME, or --between A B for the straight line between two")
    name = found[0] if line is None else line
    return name, *_drifting(log, name, log.port(name, "nodes")[:, :, :2], drift)


def straight_shapes(log: Log, ends: tuple[str, str], drift: tuple[float, float]) -> tuple[str, np.ndarray, np.ndarray]:
    """The same of the straight line between two positions, such as `left.hook_a.position`.

    Raises TowlineError where one is no position of a channel, or they are not equally frequent.
    """
    places = []
    for end in ends:
        channel, _, name = end.partition(".")
        port = log.channel(channel).port(name or "position")[0]
        if port.unit != "m" or port.shape not in ((2,), (3,)):
            raise TowlineError(
                f"{log.path}: {end} is no position: it has the shape {port.shape} and the unit {port.unit}"
            )
        places.append((channel, log.port(channel, port.name)))
    (first, a), (second, b) = places
    if not np.array_equal(log.times(first), log.times(second)):
        raise TowlineError(f"{log.path}: {ends[0]} and {ends[1]} are not recorded at the same times")
    return f"{ends[0]} to {ends[1]}", *_drifting(log, first, np.stack([a[:, :2], b[:, :2]], axis=1), drift)


def _drifting(log: Log, name: str, shapes: np.ndarray, drift: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    t = log.times(name) * 1e-9
    if len(t) < 2:
        raise TowlineError(f"{log.path}: {name} has {len(t)} shapes; a swept area needs two at least")
    return t, shapes - (t - t[0])[:, None, None] * np.array(drift)
