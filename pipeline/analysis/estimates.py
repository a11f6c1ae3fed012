"""What estimators of a line say in a log, beside the line that was simulated there, if there is one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.analysis.markers import is_estimate, is_line
from pipeline.analysis.page.signals import Signals

MARKS = ("end_tension", "deviation.end_tension", "nis", "freedom", "angle", "nodes")  # ports that tell an estimator
MARKS_OF_WHOLE = ("nodes", "tension", "deviation.tension", "deviation.end_b", "nis", "freedom", "held")
SAMPLES = 25  # frames by which it is found which part of the line is estimated


@dataclass(frozen=True)
class Estimate:
    """Over t: (k,) [s]. angle, rate, moment: (k, n), see estimator ports; the true ones are None where not known.

    contradicted: (k,) whether sensors contradicted each other or the estimate; beginnings: (k,) how often it had begun
    anew. None where it does not tell.
    """

    name: str
    t: np.ndarray
    angle: np.ndarray
    rate: np.ndarray
    moment: np.ndarray
    tension: np.ndarray
    deviation: np.ndarray
    nis: np.ndarray
    freedom: np.ndarray
    contradicted: np.ndarray | None
    beginnings: np.ndarray | None
    true_angle: np.ndarray | None
    true_tension: np.ndarray | None


@dataclass(frozen=True)
class TetherEstimate:
    """Of a whole line, over t: (k,) [s]. tension, deviation: (k, 2) at ends a and b [N]. place: (k, 3) standard
    deviations of end b [m], NED. nis, freedom: (k, 2), of the position and of the tension. held: (k,) no line fits.

    off: (k, n) the nodes' distances from the simulated line's points at the same share of the length [m]; off_end:
    (k, 3) of end b, NED [m]; true_tension: (k, 2). None where no line, or more than one, was simulated.
    """

    name: str
    t: np.ndarray
    tension: np.ndarray
    deviation: np.ndarray
    place: np.ndarray
    nis: np.ndarray
    freedom: np.ndarray
    held: np.ndarray
    off: np.ndarray | None
    off_end: np.ndarray | None
    true_tension: np.ndarray | None


def estimates(signals: Signals) -> list[Estimate]:
    """All estimators of the bars of a line in a log; the truth is that of the only line in it."""
    line = _only_line(signals)
    return [_estimate(signals, name, line) for name in signals.having(*MARKS) if _is_shape(signals, name)]


def tether_estimates(signals: Signals) -> list[TetherEstimate]:
    """All estimators of a whole line between two ends; the truth likewise."""
    line = _only_line(signals)
    names = [name for name in signals.having(*MARKS_OF_WHOLE) if _is_shape(signals, name)]
    pairs = [name for name in names if signals.shape(name, "tension") == signals.shape(name, "nis") == (2,)]
    return [_of_whole(signals, name, line) for name in pairs]


def _is_shape(signals: Signals, name: str) -> bool:
    return is_line(signals.shape(name, "nodes"))


def _only_line(signals: Signals) -> str | None:
    """The line that was simulated, if there is one only."""
    named = [name for name in signals.having("nodes", "tension") if not is_estimate(signals.channels[name])]
    found = [name for name in named if _is_shape(signals, name) and len(signals.shape(name, "tension")) == 1]
    return found[0] if len(found) == 1 else None


def _estimate(signals: Signals, name: str, line: str | None) -> Estimate:
    t, angle = signals.t(name), signals.port(name, "angle")
    truth = (None, None) if line is None else _truth(signals, name, line, t)
    doubts = [signals.port(name, port) if signals.has(name, port) else None for port in ("contradiction", "beginnings")]
    contradicted = None if doubts[0] is None else doubts[0] > 0.0
    return Estimate(
        name, t, angle, signals.port(name, "rate"), signals.port(name, "moment"), signals.port(name, "end_tension"),
        signals.port(name, "deviation.end_tension"), signals.port(name, "nis"), signals.port(name, "freedom"),
        contradicted, doubts[1], *truth,
    )  # fmt: skip


def _of_whole(signals: Signals, name: str, line: str | None) -> TetherEstimate:
    t, nodes = signals.t(name), signals.port(name, "nodes")
    off = off_end = tension = None
    if line is not None:
        frames = _frames(signals, line, t)
        true = signals.port(line, "nodes")[frames]
        off = np.linalg.norm(nodes - _at_shares(true, _shares(nodes)), axis=2)
        off_end = nodes[:, -1] - true[:, -1]
        tension = np.stack([_end_tension(signals, line, end)[frames] for end in "ab"], axis=1)
    return TetherEstimate(
        name, t, signals.port(name, "tension"), signals.port(name, "deviation.tension"),
        signals.port(name, "deviation.end_b"), signals.port(name, "nis"), signals.port(name, "freedom"),
        signals.port(name, "held"), off, off_end, tension,
    )  # fmt: skip


def _frames(signals: Signals, line: str, t: np.ndarray) -> np.ndarray:
    """The last message of the line at each of the times."""
    return np.clip(np.searchsorted(signals.t(line), t + 1e-9) - 1, 0, None)


def _end_tension(signals: Signals, line: str, end: str) -> np.ndarray:
    """(k,) what the line pulls with at its end: the force there, which a slack element has none of."""
    if signals.has(line, f"force_{end}"):
        return np.linalg.norm(signals.rows(line, f"force_{end}"), axis=1)
    return np.maximum(signals.port(line, "tension")[:, 0 if end == "a" else -1], 0.0)


def _shares(nodes: np.ndarray) -> np.ndarray:
    """(k, n) of the length from the first node on; 0 throughout where they stand in one place."""
    along = np.insert(np.linalg.norm(np.diff(nodes, axis=1), axis=2).cumsum(axis=1), 0, 0.0, axis=1)
    return along / np.maximum(along[:, -1:], 1e-300)


def _at_shares(nodes: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """(k, m, 3) points of lines (k, n, 3) at shares (k, m) of their length."""
    own = _shares(nodes)
    return np.array(
        [
            np.stack([np.interp(share, at, line[:, axis]) for axis in range(3)], axis=1)
            for share, at, line in zip(shares, own, nodes, strict=True)
        ]
    ).reshape(*shares.shape, 3)


def _truth(signals: Signals, name: str, line: str, t: np.ndarray) -> tuple[np.ndarray, np.ndarray] | tuple[None, None]:
    """True angles of the bars and tension at the end, on the part of the line nearest to the estimated nodes."""
    frames = _frames(signals, line, t)
    nodes, tension = signals.port(line, "nodes")[frames][:, :, [0, 2]], signals.port(line, "tension")[frames]
    own = signals.port(name, "nodes")[:, :, [0, 2]]
    both = np.flatnonzero(np.isfinite(nodes).all(axis=(1, 2)) & np.isfinite(own).all(axis=(1, 2)))
    if not len(both):
        return None, None
    sample = both[np.linspace(0, len(both) - 1, SAMPLES).astype(int)]
    places = np.median([_nearest(nodes[k], own[k]) for k in sample], axis=0)
    segment = np.minimum(places.astype(int), nodes.shape[1] - 2)
    part = (places - segment)[:, None]
    points = (1.0 - part) * nodes[:, segment] + part * nodes[:, segment + 1]
    chords = np.diff(points, axis=1)
    middles = np.arange(tension.shape[1]) + 0.5
    end = np.array([np.interp(places[-1], middles, row) for row in tension])
    return np.arctan2(chords[..., 1], chords[..., 0]), end


def _nearest(nodes: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(p,) places on a line of nodes (n+1, 2), in segments, nearest to points (p, 2)."""
    chord = np.diff(nodes, axis=0)
    square = np.maximum((chord**2).sum(axis=1), 1e-300)
    part = np.clip(((points[:, None] - nodes[:-1]) * chord).sum(axis=2) / square, 0.0, 1.0)
    gap = np.linalg.norm(nodes[:-1] + part[..., None] * chord - points[:, None], axis=2)
    best = gap.argmin(axis=1)
    return best + part[np.arange(len(points)), best]
