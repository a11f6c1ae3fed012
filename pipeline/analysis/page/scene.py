"""Lines and bodies over time, as the animation and the map draw them: places at equal times, as small integers."""

from __future__ import annotations

from typing import Any

import numpy as np

from pipeline.analysis.markers import MarkerFrames, is_estimate, is_markers
from pipeline.analysis.page.charts import encoded
from pipeline.analysis.page.motion import bodies
from pipeline.analysis.page.signals import Signals
from pipeline.analysis.page.tensions import lines
from pipeline.analysis.scenario_entries import number

FRAMES = 1200  # of the animation, between which it draws straight on
NODES = 60  # of a line
STEPS = 65535  # of a coordinate between its least and its greatest value
NOT_DRAWN = ("reference", "estimate", "wave", "low")  # bundles that are no bodies of their own
Scene = dict[str, Any]


def of_log(signals: Signals) -> Scene | None:
    """Of a log; None where nothing in it has a place."""
    count = min(FRAMES, max((len(signals.t(name)) for name in [*lines(signals), *_moving(signals)]), default=0))
    if count < 1:
        return None
    t = np.linspace(signals.start, signals.end, count)
    drawn = [_line(name, _at(signals, name, "nodes", t)) for name in lines(signals)]
    rigid = [
        _body(name, _at(signals, name, "position", t), _turned(signals, name, t), _size(signals, name))
        for name in bodies(signals)
    ]
    points = [_body(_called(name, port), _at(signals, name, port, t), None, None) for name, port in _points(signals)]
    tracked = [_markers(name, signals, t) for name in signals.having("position", "valid") if _is_tracker(signals, name)]
    found = {
        "lines": [one for one in drawn if one],
        "bodies": [one for one in [*rigid, *points] if one],
        "markers": [one for one in tracked if one],
    }
    if not any(found.values()):
        return None
    return {"t": [float(t[0]), float(t[-1])], "frames": count, **found, "paths": _paths(signals)}


def of_markers(frames: MarkerFrames) -> Scene | None:
    """Of a table of markers; None where none is ever seen."""
    if not frames.valid.any():
        return None
    every = max(1, len(frames.t_ns) // FRAMES)
    held = _held(frames.position, frames.valid)[::every]
    t = frames.t_ns[::every] / 1e9
    line = _line("markers", held.reshape(len(held), -1))
    times = [float(t[0]), float(t[-1])]
    return {"t": times, "frames": len(t), "lines": [line], "bodies": [], "markers": [], "paths": []}


def _moving(signals: Signals) -> list[str]:
    return [*bodies(signals), *(name for name, _ in _points(signals))]


def _points(signals: Signals) -> list[tuple[str, str]]:
    """Points that move by themselves: bundles of a place and a velocity, but of a body, a sensor or an estimator."""
    found = []
    for name, info in signals.channels.items():
        if name in bodies(signals) or is_estimate(info):
            continue
        for port in signals.ports(name):
            bundle = port.removesuffix("position")
            of = signals.channels[name].port(port)[0]
            is_place = port.endswith("position") and of.shape == (3,) and of.frame == "NED" and of.unit == "m"
            if is_place and signals.has(name, f"{bundle}velocity") and not bundle.startswith(NOT_DRAWN):
                found.append((name, port))
    return found


def _called(name: str, port: str) -> str:
    """`hand` for hand.motion.position, `ball` for ball.hook.position, `boats.left` for boats.left.position."""
    return f"{name}.{port}".removesuffix(".position").removesuffix(".motion").removesuffix(".hook")


def _is_tracker(signals: Signals, name: str) -> bool:
    return is_markers(signals.shape(name, "position"), signals.shape(name, "valid"))


def _at(signals: Signals, name: str, port: str, t: np.ndarray) -> np.ndarray:
    """A port's places (k, 3 m) at other times, linear between messages; without points that are nowhere known."""
    times, values = signals.t(name), signals.port(name, port)
    if values.ndim == 3 and values.shape[1] > NODES:
        values = values[:, np.linspace(0, values.shape[1] - 1, NODES).round().astype(int)]
    if np.isnan(values).any():
        places = values.reshape(len(values), -1, 3)
        values = _held(places, np.isfinite(places.sum(axis=2)))
    values = values.reshape(len(values), -1)
    after = np.clip(np.searchsorted(times, t), 1, max(1, len(times) - 1))
    if len(times) < 2:
        return np.repeat(values, len(t), axis=0)
    share = np.clip((t - times[after - 1]) / (times[after] - times[after - 1]), 0.0, 1.0)[:, None]
    return values[after - 1] * (1.0 - share) + values[after] * share


def _turned(signals: Signals, name: str, t: np.ndarray) -> np.ndarray:
    """Roll, pitch, yaw at other times: (k, 3) [rad]."""
    times, attitude = signals.t(name), signals.port(name, "attitude")
    seen = ~np.isnan(attitude).any(axis=1)
    if not seen.any():
        return np.zeros((len(t), 3))
    turned = np.unwrap(attitude[seen], axis=0)
    return np.stack([np.interp(t, times[seen], turned[:, i]) for i in range(3)], axis=1)


def _size(signals: Signals, name: str) -> list[float] | None:
    """Length, beam and draught [m] by the parameters; None where they are not told."""
    hull = signals.entries.given(name, "hull")
    if not isinstance(hull, dict):
        return None
    told = (number(hull.get(key)) for key in ("length", "beam", "draught"))
    size = [one for one in told if one is not None]
    return size if len(size) == 3 else None


def _quantised(places: np.ndarray) -> dict[str, Any]:
    """(k, 3 n) as integers from 0 to STEPS between the least and the greatest coordinate of each axis."""
    points = places.reshape(len(places), -1, 3)
    least, greatest = points.min(axis=(0, 1)), points.max(axis=(0, 1))
    span = np.maximum(greatest - least, 1e-9)
    whole = np.round((points - least) / span * STEPS)
    return {"min": least.tolist(), "span": span.tolist(), "n": points.shape[1], "data": encoded(whole, "<u2")}


def _line(name: str, places: np.ndarray) -> dict[str, Any] | None:
    """None where nothing is known of it."""
    return {"name": name, **_quantised(places)} if places.size else None


def _markers(name: str, signals: Signals, t: np.ndarray) -> dict[str, Any] | None:
    """Markers as they were seen; None where none was."""
    places = signals.port(name, "position")
    seen = (signals.port(name, "valid") > 0.5) & ~np.isnan(places).any(axis=2)
    if not seen.any():
        return None
    index = np.clip(np.searchsorted(signals.t(name), t, "right") - 1, 0, None)
    held = _held(places, seen)[index]
    return {"name": name, **_quantised(held.reshape(len(held), -1))}


def _held(place: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Places (k, m, 3) of the markers that are ever seen (k, m): a lost one stands where it was last, or will be."""
    place, seen = place[:, seen.any(axis=0)], seen[:, seen.any(axis=0)]
    last = np.maximum.accumulate(np.where(seen, np.arange(len(place))[:, None], -1), axis=0)
    return place[np.where(last < 0, seen.argmax(axis=0), last), np.arange(place.shape[1])]


def _body(name: str, place: np.ndarray, attitude: np.ndarray | None, size: list[float] | None) -> dict[str, Any] | None:
    if not place.size:
        return None
    turned = None if attitude is None else encoded(attitude, "<f4")
    return {"name": name, **_quantised(place), "attitude": turned, "size": size}


def _paths(signals: Signals) -> list[dict[str, Any]]:
    """Where bodies were told to go: north and east of references."""
    found = []
    for name in signals.having("reference.position"):
        reference = signals.port(name, "reference.position")
        if reference.ndim == 2 and signals.channels[name].port("reference.position")[0].frame == "NED":
            reference = reference[~np.isnan(reference).any(axis=1)]
            every = max(1, len(reference) // FRAMES)
            found.append({"name": f"reference of {name}", "data": encoded(reference[::every, :2], "<f4")})
    return found
