"""The linear model of a riser, Trigo et al. 2014, (13)-(28): as printed, and with the equations corrected.

State (22), (25): modal angles and rates in turn, then the modal forces, which random walks drive (24).
"""

from __future__ import annotations

from math import ceil, log2
from typing import NamedTuple

import numpy as np
from scipy.linalg import cholesky, expm

from components.estimator.line import Line
from components.tether.linkage.lagrangian import HEAD

MOST_DECAY = 8.0  # e^8 times the rounding of the exponential is 7e-13


class Modal(NamedTuple):
    """modes: (n, n) L of (19); transition: (3n, 3n) Phi of (27); noise: (3n, 3n) of a step; weights, springs: (n,)."""

    modes: np.ndarray
    transition: np.ndarray
    noise: np.ndarray
    weights: np.ndarray
    springs: np.ndarray


def joints(n: int) -> np.ndarray:
    """(n, n): the bars' angles by those of the joints."""
    return np.tril(np.ones((n, n)))


def inertia(line: Line) -> np.ndarray:
    """M of (18) by the joints' angles, from the bars' own rates: Lagrange's, about the straight chain."""
    n, T = line.bars, joints(line.bars)
    return T.T @ line.chain()[HEAD : HEAD + n * n].reshape(n, n) @ T


def printed_inertia(line: Line) -> np.ndarray:
    """M as (9) and (A-1)-(A-5) have it, whose rates are the joints'; with J of a rod, which is not given.

    (13) and (15) print other numbers in the first element and the second column, with which M is not definite.
    """
    n, l, m = line.bars, line.bar, line.mass_per_length * line.bar
    after = n - 1 - np.maximum.outer(np.arange(n), np.arange(n))
    M = 0.5 * m * l * l * (2.0 * after + line.gamma)
    M[np.diag_indices(n)] = m * l * l * (0.25 * line.gamma**2 + np.diag(after))
    return M + m * l * l / 12.0 * (after + 1)


def damping(line: Line) -> np.ndarray:
    """By the joints' rates: drag across, linear, on straight bars. The paper has none."""
    n, l, T = line.bars, line.bar, joints(line.bars)
    part = line.normal_friction * l
    after = l * (n - 1 - np.maximum.outer(np.arange(n), np.arange(n)))
    C = part * l * (0.5 * l + after)
    C[np.diag_indices(n)] = part * l * (l / 3.0 + np.diag(after))
    return T.T @ C @ T


def weights(line: Line) -> np.ndarray:
    """(n,) moments of the weight about the joints [N m], of the straight and level chain: the constants of (13)-(17).

    (17) prints l for l^2.
    """
    after = line.bars - 1 - np.arange(line.bars)
    return np.cumsum((line.weight * line.bar**2 * (after + 0.5 * line.gamma))[::-1])[::-1]


def rates(M: np.ndarray, C: np.ndarray, K: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """L (n, n), orthonormal, and A (3n, 3n) of (25)."""
    n = len(M)
    diagonal, L = np.linalg.eigh(M)
    A = np.zeros((3 * n, 3 * n))
    angle, rate, force = np.arange(0, 2 * n, 2), np.arange(1, 2 * n, 2), np.arange(2 * n, 3 * n)
    A[angle, rate] = 1.0
    A[np.ix_(rate, angle)] = -(L.T @ K @ L) / diagonal[:, None]
    A[np.ix_(rate, rate)] = -(L.T @ C @ L) / diagonal[:, None]
    A[rate, force] = 1.0 / diagonal
    return L, A


def corrected(line: Line, density: float, interval: float) -> Modal:
    """noise: the lower root of Q_d; density: of the modal forces' white rates [N^2 m^2 / s]; interval: a step [s].

    Phi and Q_d by Van Loan 1978, "Computing integrals involving the matrix exponential", over a part of the step
    in which nothing decays by more than e^MOST_DECAY, as that decay grows in the exponential of -A, and then doubled.
    """
    L, A = rates(inertia(line), damping(line), np.diag(line.springs()))
    N, force = len(A), np.arange(2 * line.bars, 3 * line.bars)
    Q = np.zeros((N, N))
    Q[force, force] = density
    fastest = interval * np.abs(np.linalg.eigvals(A)).max()
    doublings = max(0, ceil(log2(max(fastest, 1e-300) / MOST_DECAY)))
    whole = expm(interval / 2**doublings * np.block([[-A, Q], [np.zeros((N, N)), A.T]]))
    F = whole[N:, N:].T
    Q_d = F @ whole[:N, N:]
    for _ in range(doublings):
        F, Q_d = F @ F, Q_d + F @ Q_d @ F.T
    scale = np.sqrt(np.diag(Q_d))
    root = scale[:, None] * cholesky(0.5 * (Q_d + Q_d.T) / np.outer(scale, scale), lower=True)
    return Modal(L, F, root, weights(line), line.springs())


def published(line: Line, density: float, interval: float) -> Modal:
    """noise: B_d Q B_d' of (30), Q being of the five forces; it is given as fifteen, which B_d does not fit."""
    L, A = rates(printed_inertia(line), np.zeros((line.bars, line.bars)), np.diag(line.springs()))
    N, n = len(A), line.bars
    B = np.zeros((N, n))
    B[2 * n :] = np.eye(n)
    held = expm(interval * np.block([[A, B], [np.zeros((n, N + n))]]))
    B_d = held[:N, N:]
    return Modal(L, held[:N, :N], density * B_d @ B_d.T, weights(line), line.springs())


def numbers(line: Line, modal: Modal) -> list[np.ndarray]:
    """What the kernels take of a model: L, T L, Phi, noise, weights, springs, in rows."""
    T = joints(line.bars)
    return [part.ravel() for part in (modal.modes, T @ modal.modes, *modal[1:])]
