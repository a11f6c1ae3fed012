"""The linear filter of a riser with the equations corrected: parameters and sizes."""

from __future__ import annotations

import numpy as np

from components.contract import Port, Sizes, quantity
from components.estimator import line, modal, straight
from components.estimator.contradiction import KEPT
from components.estimator.linear import CHORD, NODE
from components.estimator.straight import Linear


class Corrected(Linear):
    """(18)-(33) with Lagrange's mass matrix, damping, Phi P Phi' + Q_d, and angles measured as they are."""

    force_noise: float = quantity("N*m/s^0.5", "density of the modal forces' white rates (24)", tunable=True, gt=0)

    def vector(self) -> np.ndarray:
        """In the order of linear.py."""
        return self.numbers(modal.corrected(self, self.force_noise**2, self.interval))


def outputs(given: Corrected) -> tuple[Port, ...]:
    """Those of all estimators, and whether the estimate is contradicted."""
    return straight.outputs(given) + line.doubts()


def sizes(given: Corrected) -> Sizes:
    """State: estimate, root of its covariance, refusals of nodes, what is kept of contradictions.

    Scratch: nodes, chords, rows, a wide matrix.
    """
    n = given.bars
    N = 3 * n
    return Sizes(state=N + N * N + n + 1 + KEPT, workspace=NODE * (n + 1) + n + CHORD * n + 6 * N + 2 * N * N)
