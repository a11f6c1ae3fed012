"""How a camera was shifted: the marks fixed in the tank, seen now against where they were seen at calibration."""

from __future__ import annotations

import numpy as np

AGREE = 2.0  # marks that moved alike within this belong together [pixel]


def find_shift(spots: np.ndarray, marks: np.ndarray, last: np.ndarray, limit: float) -> tuple[np.ndarray, int]:
    """The shift (2,) that most marks (j, 2) agree on, of equal ones the nearest to the last; and how many do.

    spots: (k, 2); limit: how far the marks are looked for; all in pixels. The last shift and 0 where there is no spot.
    """
    moves = spots[None] - marks[:, None]
    guesses = moves[np.linalg.norm(moves, axis=2) <= limit]
    if not len(guesses):
        return last, 0
    away = np.linalg.norm(moves[None] - guesses[:, None, None], axis=3)
    alike = (away.min(axis=2) < AGREE).sum(axis=1)
    best = np.lexsort((np.linalg.norm(guesses - last, axis=1), -alike))[0]
    return guesses[best], int(alike[best])


def rigid_shift(marks: np.ndarray, seen: np.ndarray, middle: np.ndarray) -> tuple[float, float, float]:
    """Shift u, v [pixel] after a turn about the middle (2,) that take marks (j, 2) to seen (j, 2), by least squares.

    And the turn's angle, to first order [rad]; 0 with a single mark.
    """
    a, b = marks - middle, seen - middle
    ca, cb = a - a.mean(axis=0), b - b.mean(axis=0)
    square = (ca**2).sum()
    angle = float((ca[:, 0] * cb[:, 1] - ca[:, 1] * cb[:, 0]).sum() / square) if square > 0.0 else 0.0
    (mu, mv), (su, sv) = a.mean(axis=0), b.mean(axis=0)
    return float(su - mu + angle * mv), float(sv - mv - angle * mu), angle
