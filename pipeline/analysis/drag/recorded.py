"""Pictures of a steady tow from a log: where boats and views are, which instants are steady, what the pulls were."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import yaml

from pipeline.analysis.drag.pictures import Pictures
from pipeline.errors import LogError, TowlineError
from pipeline.log.reader import Log
from pipeline.quantities import si_value
from pipeline.signals import locate, reference

SCENARIO = "scenario.yaml"  # the attachment with the resolved scenario
SETTLED = (
    1.0  # way that boats must have gone steadily, over the length: from any arc the line is then within 2e-4 of it
)
STEADY = 0.01  # what the ends may move against each other and from a straight way meanwhile, over the length
NOISE = 4.0  # deviations of the boats' positions that are added to it
RECENT = 0.2  # way over which a speed is taken, over the length
MOST = 300  # pictures that are taken at most, evenly chosen
SLACK, NARROW = 1e-6, 0.05  # over the length: slack and distance across the tow below which a picture is left out
NONE = "-"  # a boat without view, an end without pull


@dataclass(frozen=True)
class Boat:
    """Signals of a boat, such as `port_boat.low.position`, `port_boat.low.heading`; view: its channel, or "-"."""

    position: str
    heading: str
    view: str


@dataclass(frozen=True)
class Asked:
    """What of a log is to be taken.

    boats: both, None: as the log's views are wired. hook: where both hold the line, ahead and to starboard [m]. length:
    of the line [m], noise: a point's deviation [m], None: as the log's scenario says. window: times [s]. drift: of the
    water, north and east [m/s]. pulls: signals of the forces at the boats' ends, None: none; pull_error: their relative
    deviation. position_error: of the boats [m], for what counts as steady.
    """

    boats: tuple[Boat, Boat] | None = None
    hook: tuple[float, float] = (0.0, 0.0)
    length: float | None = None
    noise: float | None = None
    window: tuple[float, float] | None = None
    drift: tuple[float, float] = (0.0, 0.0)
    pulls: tuple[str, str] | None = None
    pull_error: float = 0.02
    position_error: float = 0.0


def pictures(log: Log, asked: Asked) -> tuple[Pictures, int]:
    """The steady pictures, and how many there were in the window. Raises TowlineError where there are none."""
    entries = _entries(log)
    boats = asked.boats or _wired(log, entries)
    views = [boat.view for boat in boats if boat.view != NONE]
    if strange := [view for view in views if view not in _views(log)]:
        raise TowlineError(
            f"{log.path}: {strange[0]} is no view of a rope; there are {', '.join(_views(log)) or 'none'}"
        )
    length = asked.length or _length(log, entries, views[0])
    t = np.unique(np.concatenate([log.times(view) for view in views])) * 1e-9
    if asked.window is not None:
        t = t[(t >= asked.window[0]) & (t <= asked.window[1])]
    if not len(t):
        raise TowlineError(f"{log.path}: no picture was taken from {_span(asked.window)}")
    pose = np.stack([_pose(log, boat, t) for boat in boats], axis=1)
    middle = pose[:, :, :2].mean(axis=1) - t[:, None] * np.array(asked.drift)
    apart = pose[:, 1, :2] - pose[:, 0, :2]
    allowed = STEADY * length + NOISE * asked.position_error
    since = [_since(middle, apart, k, SETTLED * length, allowed) for k in range(len(t))]
    steady = np.array([k for k, first in enumerate(since) if first is not None], int)
    if not len(steady):
        raise TowlineError(
            f"{log.path}: none of {len(t)} pictures is of a steady tow: the boats never keep direction and distance "
            f"within {allowed:.2g} m over {SETTLED * length:.4g} m; give a longer run, or --drift of the water"
        )
    kept = steady[np.unique(np.linspace(0, len(steady) - 1, min(MOST, len(steady))).round().astype(int))]
    way = np.array([middle[k] - middle[since[k]] for k in kept])
    seen = [_seen(log, entries, boat, t[kept], asked) for boat in boats]
    points = np.zeros((len(kept), 2, max(one.shape[1] for _, one in seen), 2))
    deviation = np.full(points.shape[:3], np.inf)
    for end, (there, error) in enumerate(seen):
        points[:, end, : there.shape[1]], deviation[:, end, : error.shape[1]] = there, error
    found = Pictures(
        length=length, pose=pose[kept], hook=asked.hook, heading=np.arctan2(way[:, 1], way[:, 0]),
        speed=np.array([_speed(t, middle, k, RECENT * length) for k in kept]), points=points, deviation=deviation,
        pull=_pulls(log, asked.pulls, t[kept]), pull_error=asked.pull_error,
    )  # fmt: skip
    return _between_bounds(log, found, asked), len(t)


def _between_bounds(log: Log, found: Pictures, asked: Asked) -> Pictures:
    """Those in which the line can reach from end to end, and the boats are not one behind the other."""
    ends, _ = found.placed(np.zeros(6))
    apart = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    across = np.abs(ends[:, 1, 0] - ends[:, 0, 0])
    taut = apart > found.length * (1.0 - SLACK) - NOISE * asked.position_error
    good = ~taut & (across > NARROW * found.length)
    if not good.any():
        raise TowlineError(
            f"{log.path}: the line's ends are {np.median(apart):.4g} m apart, {np.median(across):.4g} m of it across "
            f"the tow, and the line is {found.length:.4g} m long: its shape then tells nothing; check --length, --hook"
        )
    return replace(found, **{name: getattr(found, name)[good] for name in
                             ("pose", "heading", "speed", "points", "deviation", "pull")})  # fmt: skip


def _span(window: tuple[float, float] | None) -> str:
    return "first to last" if window is None else f"{window[0]:g} to {window[1]:g} s"


def _since(middle: np.ndarray, apart: np.ndarray, k: int, way: float, allowed: float) -> int | None:
    """From which instant on the boats have gone straight and apart alike for this way [m], or None."""
    gone = np.hypot(*(middle[k] - middle[: k + 1]).T)
    far = np.flatnonzero(gone >= way)
    if not len(far):
        return None
    first = int(far[-1])
    along = (middle[k] - middle[first]) / gone[first]
    aside = (middle[first : k + 1] - middle[k]) @ np.array([-along[1], along[0]])
    moved = np.hypot(*(apart[first : k + 1] - apart[k]).T)
    return first if max(np.abs(aside).max(), moved.max()) <= allowed else None


def _speed(t: np.ndarray, middle: np.ndarray, k: int, way: float) -> float:
    """Through the water over the last part of the way [m/s]."""
    gone = np.hypot(*(middle[k] - middle[: k + 1]).T)
    first = int(np.flatnonzero(gone >= way)[-1])
    return float(gone[first] / (t[k] - t[first]))


def _entries(log: Log) -> dict:
    """The components of the log's scenario; {} where it has none."""
    try:
        document = yaml.load(log.attachment(SCENARIO), Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
        return dict(document["components"])
    except (LogError, yaml.YAMLError, KeyError, TypeError):
        return {}


def _views(log: Log) -> list[str]:
    """Channels of points in a boat's frame."""
    return [name for name, one in log.channels.items() if {"points", "valid"} <= {port.name for port in one.ports}]


def _wired(log: Log, entries: dict) -> tuple[Boat, Boat]:
    """The boats by the wires of two views."""
    views = _views(log)
    wires = [entries.get(view, {}).get("inputs", {}) for view in views]
    if len(views) != 2 or not all(isinstance(one.get(name), str) for one in wires for name in ("position", "heading")):
        raise TowlineError(
            f"{log.path} has {len(views)} views of a rope ({', '.join(views) or 'none'}) whose boats it tells; "
            f"expected two: give --boat POSITION HEADING VIEW for each boat ({NONE} for no view)"
        )
    first, second = (Boat(one["position"], one["heading"], view) for one, view in zip(wires, views, strict=True))
    return first, second


def _length(log: Log, entries: dict, view: str) -> float:
    """Of the line behind a view [m]."""
    wire = entries.get(view, {}).get("inputs", {}).get("nodes", "")
    given = entries.get(str(wire).partition(".")[0], {}).get("parameters", {}).get("length", "")
    number, _, unit = str(given).partition(" ")
    if unit != "m":
        raise TowlineError(f"{log.path} does not tell the line's length: give --length")
    return float(number)


def signal(log: Log, text: str, unit: str, size: int, t: np.ndarray) -> np.ndarray:
    """A signal at these times, linear between its own, or a constant: (k, c) with at least `size` columns.

    Raises TowlineError where there is no such signal, or it has another unit or fewer numbers.
    """
    if size == 1:
        try:
            return np.full((len(t), 1), si_value(text, unit, bare=True))
        except ValueError:
            pass
    try:
        wanted = reference(text)
        channel = log.channel(wanted.component)
        members = locate(wanted.component, channel.ports, 0, wanted.port, wanted.slice, kind="output")
    except (ValueError, LogError) as error:
        raise TowlineError(f"{log.path}: {error}") from error
    found = members.get("")
    if found is None or found.unit != unit or len(found.indices) < size:
        raise TowlineError(f"{log.path}: {text} is no signal of {size} or more numbers in {unit}")
    times, values = log.times(wanted.component) * 1e-9, log.values(wanted.component)[:, list(found.indices)]
    if not len(times) or t[0] < times[0] or t[-1] > times[-1] + 2.0 * (times[-1] - times[0]) / len(times):
        raise TowlineError(f"{log.path}: {text} does not cover the pictures' times")
    return np.column_stack([np.interp(t, times, np.unwrap(one) if unit == "rad" else one) for one in values.T])


def _pose(log: Log, boat: Boat, t: np.ndarray) -> np.ndarray:
    """North, east, heading: (k, 3)."""
    place, heading = signal(log, boat.position, "m", 2, t)[:, :2], signal(log, boat.heading, "rad", 1, t)[:, :1]
    return np.concatenate([place, heading], axis=1)


def _seen(log: Log, entries: dict, boat: Boat, t: np.ndarray, asked: Asked) -> tuple[np.ndarray, np.ndarray]:
    """Points (k, m, 2) and their deviations (k, m), infinite where none is seen or none was taken at this time."""
    if boat.view == NONE:
        return np.zeros((len(t), 1, 2)), np.full((len(t), 1), np.inf)
    times = log.times(boat.view) * 1e-9
    points, valid = log.port(boat.view, "points"), log.port(boat.view, "valid") == 1.0
    at = np.searchsorted(times, t).clip(max=len(times) - 1)
    valid = valid[at] & (times[at] == t)[:, None]
    points = points[at]
    if asked.noise is not None:
        deviation = np.full(valid.shape, asked.noise)
    else:
        given = entries.get(boat.view, {}).get("parameters", {})
        noise = float(str(given.get("noise", "0")).partition(" ")[0])
        camera = np.array(given.get("camera", {}).get("values", (0.0, 0.0)))
        distance = np.hypot(*(points - camera).transpose(2, 0, 1))
        deviation = np.hypot(noise, float(given.get("noise_per_range", 0.0)) * distance)
    if valid.any() and not (deviation[valid] > 0.0).all():
        raise TowlineError(f"{log.path}: the noise of {boat.view} is 0 or not told: give --noise")
    return points, np.where(valid, deviation, np.inf)


def _pulls(log: Log, pulls: tuple[str, str] | None, t: np.ndarray) -> np.ndarray:
    """Sizes of the forces at both ends (k, 2) [N], NaN where not measured."""
    found = np.full((len(t), 2), np.nan)
    for end, text in enumerate(pulls or ()):
        if text != NONE:
            found[:, end] = np.linalg.norm(signal(log, text, "N", 1, t), axis=1)
    found[found == 0.0] = np.nan
    return found
