"""The linear filter of a riser as printed: parameters and sizes."""

from __future__ import annotations

import numpy as np

from components.contract import Sizes, Term, choice, quantity
from components.estimator import modal, straight
from components.estimator.linear import CHORD, NODE
from components.estimator.straight import Linear


class Published(Linear):
    """Trigo et al. 2014, section 4. Their EI and weights lack g: give what is to be used."""

    force_variance: float = quantity("N^2*m^2/s", "Q of the forces' white rates (24)", 0.9, gt=0)
    angle_variance: float = quantity("rad^2", "R of a joint's angle", 0.01, gt=0)
    start_variance: float = quantity("1", "P_0 of each state, whatever its unit", 0.5, gt=0)
    start_tension: float = quantity("N", "for the first forces", 0.5)
    moves_covariance: bool = choice("Phi P Phi' in (30); as printed it is P, and the estimate flies off", True)

    def vector(self) -> np.ndarray:
        """In the order of linear.py, without modes, as (26) measures; then of (30), R, P_0 and the first tension."""
        model = modal.published(self, self.force_variance, self.interval)._replace(modes=np.eye(self.bars))
        own = [self.moves_covariance, self.angle_variance, self.start_variance, self.start_tension]
        return np.append(self.numbers(model), own)


def sizes(given: Published) -> Sizes:
    """State: estimate (N) and its covariance. Scratch: records of nodes and chords, rows, a root of the covariance."""
    n = given.bars
    N = 3 * n
    return Sizes(state=N + N * N, workspace=NODE * (n + 1) + n + CHORD * n + 6 * N + N * N)


def terms(given: Published) -> tuple[Term, ...]:
    """What of the model is on: as printed neither damping nor what is known of each marker is, whatever is given."""
    return tuple(
        term if "spring" in term.name else Term(term.name, False, f"{term.why}; left out, as printed")
        for term in straight.terms(given)
    )
