"""The states of an estimator of a line smoothed over a whole log: what all frames say, those to come among them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.estimation.record import Record


@dataclass(frozen=True)
class Smoothed:
    """t_ns: (k,); states: (k, N), see the estimators; covariance: (k, N, N)."""

    t_ns: np.ndarray
    states: np.ndarray
    covariance: np.ndarray

    def deviations(self) -> np.ndarray:
        """(k, N) standard deviations of the states."""
        return np.sqrt(np.diagonal(self.covariance, axis1=1, axis2=2))


def smooth(record: Record) -> Smoothed:
    """Rauch, Tung and Striebel 1965, on the filter's own linearisation. Raises ValueError if the filter fails.

    The covariance goes back as P_k + C (P^s - P^-) C' written as a sum of squares, so that it stays definite:
    (I - C Phi) P (I - C Phi)' + C (Q + P^s) C'. What comes after the filter began anew says nothing of before.
    """
    filter_ = record.begin()
    states, roots, moves, begun = [filter_.state], [filter_.root], [], [filter_["beginnings"]]
    for u in record.inputs[1:]:
        moves.append(filter_.moved(filter_.state))
        filter_.step(u)
        states.append(filter_.state)
        roots.append(filter_.root)
        begun.append(filter_["beginnings"])
    x, P = states[-1], roots[-1] @ roots[-1].T
    smoothed, covariance = [x], [P]
    anew = np.diff(begun)[::-1] > 0
    for state, root, (ahead, phi, noise), cut in zip(states[-2::-1], roots[-2::-1], moves[::-1], anew, strict=True):
        own, Q = root @ root.T, noise @ noise.T
        if cut:
            x, P = state, own
            smoothed.append(x)
            covariance.append(P)
            continue
        predicted = phi @ own @ phi.T + Q
        scale = 1.0 / np.sqrt(np.diag(predicted))
        C = np.linalg.solve(predicted * np.outer(scale, scale), scale[:, None] * (phi @ own)).T * scale
        left = np.eye(len(state)) - C @ phi
        x, P = state + C @ (x - ahead), left @ own @ left.T + C @ (Q + P) @ C.T
        smoothed.append(x)
        covariance.append(P)
    return Smoothed(record.t_ns, np.array(smoothed[::-1]), np.array(covariance[::-1]))
