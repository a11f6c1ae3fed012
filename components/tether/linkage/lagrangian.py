"""Lagrange's equations of a chain of bars that hangs from a pivot, in the bars' own angles, and their exact slopes.

Derived anew from what Trigo et al. 2014 set out from, (7)-(12): bar i turns by theta_i from north towards down, its
centre of mass lies c from its first joint, its second joint l. With t_i = (cos, sin) theta_i, n_i = dt_i / dtheta_i,

    r_i = sum_j A_ij (cos(theta_i - theta_j) theta_j'' + sin(theta_i - theta_j) theta_j'^2) + b_i n_i . a_0
          + k_i (theta_i - theta_i-1) - k_i+1 (theta_i+1 - theta_i) - w_i cos theta_i - l n_i . F - Q_i = 0,

a_0 the pivot's acceleration, F the force on the free end, Q_i of drag. Where it departs from the paper: the angles are
the bars' own, so that the rate in (8) and (9) is that of the bar, not of the joint before it; (10) has gamma/2 in its
last term; (12) and (A-1) have minus dL/dtheta; (A-1) has J, not 3J, on theta_5'', (A-5) cos theta_5 on theta_4'', and
on theta_5'' m (gamma l / 2)^2. With the joints' angles phi_i = theta_i - theta_i-1 the equations are the sums of these
from i to n. The paper's F points along the last bar; here it has a direction of its own.
"""

from math import cos, sin
from typing import Any, NamedTuple

import numpy as np

from components.compiled import kernel
from components.matrices import table

# Gauss's two points of a bar, over its length.
FIRST, SECOND = 0.5 - 0.5 / 3.0**0.5, 0.5 + 0.5 / 3.0**0.5
HEAD = 8  # numbers before the tables
LOADS = 4  # of a pivot and an end: force on the free end (2), acceleration of the pivot (2)


class Bars(NamedTuple):
    """A chain of n bars of length l [m]: see `constants`, in whose order these lie."""

    n: int
    l: float
    c_S: float
    k_S: float
    clamp: float
    mass: float
    weight: float
    c: float
    A: Any
    b: Any
    w: Any
    k: Any


class Slopes(NamedTuple):
    """r (n) and its slopes by the angles' second rates, angles, rates (n, n), pivot's velocity (n, 2), loads (n, 4)."""

    r: Any
    M: Any
    theta: Any
    omega: Any
    v: Any
    load: Any
    J: Any
    dJ: Any
    cos: Any
    sin: Any


def constants(
    n: int, l: float, mass: float, weight: float, springs: np.ndarray, c: float, J: float,
    c_S: float, k_S: float, clamp: float,
) -> np.ndarray:  # fmt: skip
    """The numbers of a chain for `bars_at`: (HEAD + n^2 + 3 n,) float64.

    mass, weight [kg, N]: of a bar, the weight that in water; springs: (n,) [N m] of the joints, the first to a wall in
    the direction `clamp` [rad]; c [m], J [kg m^2]: a bar's centre of mass behind its first joint and moment of inertia
    about it; c_S, k_S: normal drag per length, linear [N s/m^2] and quadratic [N s^2/m^3].
    """
    after = l * np.arange(n - 1, -1, -1.0)  # from a bar's second joint to the chain's end, straight
    later = np.maximum.outer(np.arange(n), np.arange(n))
    A = mass * l * (c + after[later])
    A[np.diag_indices(n)] = mass * (c * c + l * after) + J
    head = [n, l, c_S, k_S, clamp, mass, weight, c]
    return np.concatenate([head, A.ravel(), mass * (c + after), weight * (c + after), springs])


@kernel
def bars_at(p, at):
    """The chain whose constants begin at p[at]."""
    n = int(p[at])
    end = at + HEAD + n * n
    return Bars(
        n, p[at + 1], p[at + 2], p[at + 3], p[at + 4], p[at + 5], p[at + 6], p[at + 7], table(p, at + HEAD, n, n),
        p[end : end + n], p[end + n : end + 2 * n], p[end + 2 * n : end + 3 * n],
    )  # fmt: skip


def size(n: int) -> int:
    """Scratch of `slopes_at`."""
    return 3 * n * n + 11 * n


@kernel
def slopes_at(w, at, n):
    """Room for r and its slopes at w[at]."""
    square = n * n
    end = at + n + 3 * square
    a = end + 6 * n
    return Slopes(
        w[at : at + n], table(w, at + n, n, n), table(w, at + n + square, n, n), table(w, end - square, n, n),
        table(w, end, n, 2), table(w, end + 2 * n, n, LOADS), w[a : a + n], w[a + n : a + 2 * n],
        w[a + 2 * n : a + 3 * n], w[a + 3 * n : a + 4 * n],
    )  # fmt: skip


@kernel
def drag(bars, i, xi, omega, v0, out):
    """Add the drag across at the point xi of bar i, which stands for half of it; v0 (2): the pivot's velocity."""
    l, J, dJ = bars.l, out.J, out.dJ
    c, s = out.cos[i], out.sin[i]
    v, turned = c * v0[1] - s * v0[0], -c * v0[0] - s * v0[1]
    for j in range(i):
        # The point's way across bar i by bar j's angle, and how that grows with bar i's.
        J[j], dJ[j] = l * (c * out.cos[j] + s * out.sin[j]), l * (c * out.sin[j] - s * out.cos[j])
        v, turned = v + J[j] * omega[j], turned + dJ[j] * omega[j]
    J[i], dJ[i] = xi * l, 0.0
    v += J[i] * omega[i]
    part = 0.5 * l
    force = part * (bars.c_S + bars.k_S * abs(v)) * v
    slope = part * (bars.c_S + 2.0 * bars.k_S * abs(v))
    for j in range(i + 1):
        out.r[j] += J[j] * force
        a = slope * J[j]
        out.v[j, 0] -= a * s
        out.v[j, 1] += a * c
        out.theta[j, i] += a * turned + dJ[j] * force
        out.theta[j, j] -= dJ[j] * force
        for k in range(i + 1):
            out.omega[j, k] += a * J[k]
            out.theta[j, k] -= a * dJ[k] * omega[k]


@kernel
def evaluate(bars, theta, omega, alpha, v0, load, out):
    """Write r and its slopes.

    theta, omega, alpha: (n) angles [rad], rates, second rates; v0: (2) the pivot's velocity [m/s]; load: (4) force on
    the free end [N] and the pivot's acceleration [m/s^2]; each vector north and down.
    """
    n, l = bars.n, bars.l
    for i in range(n):
        c, s = cos(theta[i]), sin(theta[i])
        out.cos[i], out.sin[i], row = c, s, out.load[i]
        row[0], row[1], row[2], row[3] = l * s, -l * c, -bars.b[i] * s, bars.b[i] * c
        across = row[0] * load[0] + row[1] * load[1] + row[2] * load[2] + row[3] * load[3]
        along = l * (c * load[0] + s * load[1]) - bars.b[i] * (c * load[2] + s * load[3])
        before = theta[i - 1] if i > 0 else bars.clamp
        out.r[i] = across - bars.w[i] * c + bars.k[i] * (theta[i] - before)
        out.v[i, 0] = out.v[i, 1] = 0.0
        for j in range(n):
            out.theta[i, j] = out.omega[i, j] = 0.0
        out.theta[i, i] = along + bars.w[i] * s + bars.k[i]
        if i > 0:
            out.theta[i, i - 1] -= bars.k[i]
        if i < n - 1:
            out.r[i] -= bars.k[i + 1] * (theta[i + 1] - theta[i])
            out.theta[i, i] += bars.k[i + 1]
            out.theta[i, i + 1] -= bars.k[i + 1]
    for i in range(n):
        c_i, s_i = out.cos[i], out.sin[i]
        for j in range(n):
            c = bars.A[i, j] * (c_i * out.cos[j] + s_i * out.sin[j])
            s = bars.A[i, j] * (s_i * out.cos[j] - c_i * out.sin[j])
            out.M[i, j] = c
            out.r[i] += c * alpha[j] + s * omega[j] * omega[j]
            out.omega[i, j] += 2.0 * s * omega[j]
            slope = c * omega[j] * omega[j] - s * alpha[j]
            out.theta[i, i] += slope
            out.theta[i, j] -= slope
    if bars.c_S > 0.0 or bars.k_S > 0.0:
        for i in range(n):
            drag(bars, i, FIRST, omega, v0, out)
            drag(bars, i, SECOND, omega, v0, out)
