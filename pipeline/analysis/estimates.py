"""What estimators of a line say in a log, beside the line that was simulated there, if there is one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.analysis.page.signals import Signals

MARKS = ("end_tension", "deviation.end_tension", "nis", "freedom", "angle", "nodes")  # ports that tell an estimator
SAMPLES = 25  # frames by which it is found which part of the line is estimated


@dataclass(frozen=True)
class Estimate:
    """Over t: (k,) [s]. angle, rate, moment: (k, n), see estimator ports; the true ones are None where not known."""

    name: str
    t: np.ndarray
    angle: np.ndarray
    rate: np.ndarray
    moment: np.ndarray
    tension: np.ndarray
    deviation: np.ndarray
    nis: np.ndarray
    freedom: np.ndarray
    true_angle: np.ndarray | None
    true_tension: np.ndarray | None


def estimates(signals: Signals) -> list[Estimate]:
    """All estimators of a line in a log; the truth is that of the only line in it."""
    ports = {name: {port.name for port in channel.ports} for name, channel in signals.channels.items()}
    found = [name for name, own in ports.items() if set(MARKS) <= own]
    lines = [name for name, own in ports.items() if {"nodes", "tension"} <= own and name not in found]
    return [_estimate(signals, name, lines[0] if len(lines) == 1 else None) for name in found]


def _estimate(signals: Signals, name: str, line: str | None) -> Estimate:
    t, angle = signals.t(name), signals.port(name, "angle")
    truth = (None, None) if line is None else _truth(signals, name, line, t)
    return Estimate(
        name, t, angle, signals.port(name, "rate"), signals.port(name, "moment"), signals.port(name, "end_tension"),
        signals.port(name, "deviation.end_tension"), signals.port(name, "nis"), signals.port(name, "freedom"), *truth,
    )  # fmt: skip


def _truth(signals: Signals, name: str, line: str, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """True angles of the bars and tension at the end, on the part of the line nearest to the estimated nodes."""
    frames = np.clip(np.searchsorted(signals.t(line), t + 1e-9) - 1, 0, None)
    nodes, tension = signals.port(line, "nodes")[frames][:, :, [0, 2]], signals.port(line, "tension")[frames]
    own = signals.port(name, "nodes")[:, :, [0, 2]]
    sample = np.linspace(0, len(t) - 1, SAMPLES).astype(int)
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
