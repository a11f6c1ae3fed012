"""Whether the markers' numbers follow the line: else the way through them is much longer than another one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pipeline.analysis.markers import MarkerFrames
from pipeline.errors import LogError

SOME = 40  # frames looked at, evenly over the record
STARTS = 24  # of the ways tried in each
MOST_POINTS = 2_000_000  # frames times ways times markers at once
# Way by the numbers over the shortest found. Two legs of a line side by side are shorter to cross to and fro than to
# follow: up to 1.5 times where they are a third of the markers' spacing apart.
REFUSED = 1.5
DOUBTED = 1.1  # two neighbours exchanged among 12 markers give 1.18


def in_line_order(frames: MarkerFrames) -> MarkerFrames:
    """The same frames, with a note where two of the markers seem exchanged throughout.

    Raises LogError, with the order that is shorter, where the numbers do not follow the line.
    """
    enough = np.flatnonzero(frames.valid.sum(axis=1) >= max(4, frames.markers // 2))
    if not len(enough):
        return frames
    chosen = np.unique(enough[np.linspace(0, len(enough) - 1, SOME).astype(int)])
    ways = [_shortest(frames.position[f][frames.valid[f]]) for f in chosen]
    given = np.array([_length(frames.position[f][frames.valid[f]]) for f in chosen])
    shortest = np.array([length for _, length in ways])
    ratio = float(np.median(given / np.where(shortest > 0.0, shortest, np.inf)))
    if ratio < DOUBTED:
        return frames
    orders = [tuple(np.flatnonzero(frames.valid[f])[way].tolist()) for f, (way, _) in zip(chosen, ways, strict=True)]
    text = (
        f"the markers' numbers do not follow the line: through them in their order it is {np.median(given):.3g} m "
        f"long, in another one {np.median(shortest):.3g} m"
    )
    if ratio < REFUSED:
        return replace(frames, notes=(*frames.notes, f"{text}, as if some were exchanged throughout"))
    usual = max(orders, key=len)
    if 2 * sum(_agree(order, usual) for order in orders) > len(orders):
        some = ", ".join(str(one + 1) for one in usual[:12]) + (", ..." if len(usual) > 12 else "")
        remedy = f"along the line they come as the file's {some} (counted from 1): number them in that order"
    else:
        remedy = "which one changes from frame to frame: give each marker an id or a label"
    raise LogError(f"{frames.source}: {text}; {remedy}")


def _agree(order: tuple[int, ...], whole: tuple[int, ...]) -> bool:
    """Whether markers are in this order, or its reverse, among all: some may not be seen."""
    expected = tuple(one for one in whole if one in order)
    return len(expected) == len(order) and order in (expected, expected[::-1])


def _length(x: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(x, axis=0), axis=1).sum())


def _shortest(x: np.ndarray) -> tuple[np.ndarray, float]:
    """The shortest way through all points by always going to the nearest, from several starts: order (n,), length [m].

    x: (n, 3). The first point of the order is the one with the lesser number of both ends.
    """
    n = len(x)
    starts = np.unique(np.linspace(0, n - 1, max(1, min(n, STARTS, MOST_POINTS // (n * n)))).astype(int))
    apart = np.linalg.norm(x[:, None] - x[None], axis=2)
    rows = np.arange(len(starts))
    free = np.ones((len(starts), n), bool)
    order = np.empty((len(starts), n), np.int64)
    order[:, 0], here, length = starts, starts, np.zeros(len(starts))
    free[rows, starts] = False
    for i in range(1, n):
        distance = np.where(free, apart[here], np.inf)
        here = distance.argmin(axis=1)
        length += distance[rows, here]
        order[:, i] = here
        free[rows, here] = False
    best = order[length.argmin()]
    return (best if best[0] < best[-1] else best[::-1]), float(length.min())
