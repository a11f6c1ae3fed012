"""What loads a recorded line beside its weight: inertia, drag by its own motion, drag by the stream.

A catenary stands under a load that is the same all along it. Where another is as large as the weight, the weight's
cannot hold; where all of them together are uneven along the line no catenary can, whatever its plane.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np

from pipeline.analysis.line_properties import Properties, Water
from pipeline.analysis.line_record import LineRecord

NODES = 50  # at which loads are taken, evenly along the line
CAUSES = {
    "acceleration": "the line's acceleration",
    "motion": "drag by its own motion",
    "current": "drag by the current",
}


@dataclass(frozen=True)
class Loads:
    """Root mean squares along the line of loads per length, (k,) each; NaN where not known.

    acceleration, motion, current: of the inertia, of the drag that the nodes' velocity would meet in still water, and
    of that which the current would give to the line at rest, over the weight in water (over the mean load where it has
    none). uneven: the same three as differences from their means along the line, over the mean of all load.
    """

    acceleration: np.ndarray
    motion: np.ndarray
    current: np.ndarray
    uneven: dict[str, np.ndarray]

    def over_weight(self) -> dict[str, np.ndarray]:
        """By cause."""
        return {"acceleration": self.acceleration, "motion": self.motion, "current": self.current}


def loads(record: LineRecord, line: Properties) -> Loads:
    """Of all frames of the record."""
    every = ceil(record.nodes.shape[1] / NODES)
    nodes, velocity, acceleration = (one[:, ::every] for one in (record.nodes, record.velocity, record.acceleration))
    tangent = np.gradient(nodes, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        tangent /= np.sqrt(np.einsum("kni,kni->kn", tangent, tangent))[..., None]
        stream = _stream(line.water, record.current, nodes)
        along = np.einsum("kni,kni->kn", acceleration, tangent)[..., None] * tangent
        parts = {
            "acceleration": -(line.mass + line.added) * acceleration + line.added * along,
            "motion": _drag(velocity, tangent, line),
            "current": _drag(-stream, tangent, line),
        }
        mean_load = (line.load + parts["acceleration"] + _drag(velocity - stream, tangent, line)).mean(axis=1)
        mean = np.linalg.norm(mean_load, axis=1)
        least = line.weight if line.weight > 0.0 else mean
        over = {name: _size(part) / least for name, part in parts.items()}
        uneven = {name: _size(part - part.mean(axis=1, keepdims=True)) / mean for name, part in parts.items()}
    return Loads(over["acceleration"], over["motion"], over["current"], uneven)


def cause(ratios: dict[str, np.ndarray], frames: np.ndarray, least: float) -> tuple[str, dict[str, float]]:
    """The largest of the causes, and the medians of all, over some frames (k,) bool; "" where none reaches `least`."""
    with np.errstate(invalid="ignore"):
        known = {name: values[frames][np.isfinite(values[frames])] for name, values in ratios.items()}
    sizes = {name: float(np.median(values)) if len(values) else 0.0 for name, values in known.items()}
    largest = max(sizes, key=lambda name: sizes[name])
    return (largest if sizes[largest] >= least else ""), sizes


def _size(loads: np.ndarray) -> np.ndarray:
    """(k, n, 3) -> (k,): root mean square along the line."""
    return np.sqrt(np.einsum("kni,kni->k", loads, loads) / loads.shape[1])


def _drag(v: np.ndarray, tangent: np.ndarray, line: Properties) -> np.ndarray:
    """Drag per length at velocity v through the water (k, n, 3): Morison et al. 1950, apart across and along."""
    s = np.einsum("kni,kni->kn", v, tangent)
    across = v - s[..., None] * tangent
    speed = np.sqrt(np.einsum("kni,kni->kn", across, across))
    k_n, k_t = line.square
    c_n, c_t = line.linear
    return -(k_n * speed + c_n)[..., None] * across - ((k_t * np.abs(s) + c_t) * s)[..., None] * tangent


def _stream(water: Water, recorded: np.ndarray | None, nodes: np.ndarray) -> np.ndarray:
    """The current at the nodes (k, n, 3) [m/s]: the parameters', and what a channel gave (k, m, 3)."""
    depth = nodes[..., 2]
    found = _at_depth(water.depths, np.broadcast_to(water.velocity, (len(depth), *water.velocity.shape)), depth)
    if recorded is not None and recorded.shape[1] == max(len(water.recorded_depths), 1):
        found = found + _at_depth(water.recorded_depths, recorded, depth)
    return found


def _at_depth(depths: np.ndarray, table: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """Tables (k, m, 3) at depths (m,), linear between and constant beyond, at the nodes' (k, n)."""
    if len(depths) < 2:
        return np.broadcast_to(table[:, :1], (*depth.shape, 3))
    below = np.clip(np.searchsorted(depths, depth), 1, len(depths) - 1)
    share = np.clip((depth - depths[below - 1]) / (depths[below] - depths[below - 1]), 0.0, 1.0)[..., None]
    frame = np.arange(len(depth))[:, None]
    return table[frame, below - 1] * (1.0 - share) + table[frame, below] * share
