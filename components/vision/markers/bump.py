"""How a camera was turned: the marks fixed in the tank, seen now against where they were seen at calibration.

A bump turns a camera; turns shift near and far alike, so that marks on the wall tell of the motion plane.
"""

from __future__ import annotations

import numpy as np

from components.vision.markers import calibration

ROUNDS = 8  # of Gauss-Newton: rounding remains after turns of some degrees
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


def turn_between(before: np.ndarray, after: np.ndarray) -> calibration.Turned:
    """The rotation that takes directions before (j, 3) to after (j, 3), by least squares; the least for one."""
    turn = np.zeros(3)
    for _ in range(ROUNDS):
        there = before @ calibration.rotation(calibration.Turned(*turn)).T
        a = there / np.linalg.norm(there, axis=1)[:, None]
        b = after / np.linalg.norm(after, axis=1)[:, None]
        # b - a = turn x a.
        cross = np.array([[[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]] for x, y, z in a])
        turn = turn + np.linalg.lstsq(cross.reshape(-1, 3), (b - a).ravel(), rcond=1e-6)[0]
    return calibration.Turned(*map(float, turn))
