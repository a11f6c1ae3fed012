"""The static line of given length and load through two given ends, for many frames at once; on a seabed too.

In units of the length L and the load q L, with e = q L / EA, a line of span h and rise v across and against its load is
the one whose sum of end tensions S = coth t fulfils

    (h sinh t / (t + e/2))^2 + (2 v / (2 + e coth t))^2 = 1,

for the point (H, V) of the force at its middle lies on the ellipse of foci (0, -1/2) and (0, 1/2) whose distances from
them sum up to S, H (2 t + e) = h and V (2 / S + e) = v. The left side grows with t from 0 to infinity (the first term
by sinh t / (t + e/2), the second by 1 / coth t), so there is one root, slack, taut or stretched; without stretch it is
the textbook's h sinh(t) / t = sqrt(1 - v^2).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

# ln t and ln H: 60 halvings of a range of 68 leave 6e-17 of it. exp(6) = 403: sinh stays finite when squared.
LOW, HIGH, HALVINGS = -62.0, 6.0, 60
HEAP = 1e-6  # share of the length that lies without room on the bed, beyond rounding
ON_BED = 1e-3  # height over length, below which an end lies on it: elements sink into a soft one
NARROW = 1e-9  # span over length, below which the ends are taken as this far apart: then H is below 1e-10 of the weight


@dataclass(frozen=True)
class Statics:
    """k static lines. tension_a, tension_b: (k,) at the ends [N]. force_a, force_b: (k, 3) on the holders [N], NED.

    shape: (k, n, 3) at the shares of the length asked for, NED [m]. NaN where there is no such line.
    """

    tension_a: np.ndarray
    tension_b: np.ndarray
    force_a: np.ndarray
    force_b: np.ndarray
    shape: np.ndarray


def through_ends(
    end_a: np.ndarray,
    end_b: np.ndarray,
    length: np.ndarray,
    load: np.ndarray,
    flexibility: float,
    share: np.ndarray,
    seabed: float = np.inf,
    rough: bool = False,
) -> Statics:
    """Lines from end_a to end_b (k, 3) NED [m] of unstretched length (k,) [m] under a uniform load (k, 3) [N/m].

    flexibility: 1/EA [1/N]; where it is 0 and the chord is not shorter than the line there is none. share: (k, n) or
    (n,) of the unstretched length from end a. seabed: depth [m]; a line that would hang below it lies on it, as long as
    its load is vertical. rough: friction there leaves open what tension comes to an end that lies on it: NaN.
    """
    q = np.linalg.norm(load, axis=1)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        up = -load / q[:, None]
        chord = end_b - end_a
        rise = (chord * up).sum(axis=1)
        across = chord - rise[:, None] * up
        span = np.linalg.norm(across, axis=1)
        along = np.where(span[:, None] > 0.0, across / span[:, None], 0.0)
        h, v, e = np.maximum(span / length, NARROW), rise / length, q * length * flexibility
        shares = np.broadcast_to(share, (len(q), share.shape[-1]))
        x, z, H, up_a, up_b = _hanging(h, v, e, shares)
        if np.isfinite(seabed):
            p_a, p_b = (seabed - end_a[:, 2]) / length, (seabed - end_b[:, 2]) / length
            p_a, p_b = (np.where((p < 0.0) & (p > -ON_BED), 0.0, p) for p in (p_a, p_b))
            lies = (z.min(axis=1) < -p_a) & (p_a >= 0.0) & (p_b >= 0.0)
            x[lies], z[lies], H[lies], up_a[lies], up_b[lies] = _lying(h, e, p_a, p_b, shares, lies)
        scale = q * length
        force_a = (scale * H)[:, None] * along + (scale * up_a)[:, None] * up
        force_b = -(scale * H)[:, None] * along + (scale * up_b)[:, None] * up
        shape = end_a[:, None] + length[:, None, None] * (x[..., None] * along[:, None] + z[..., None] * up[:, None])
        T_a, T_b = scale * np.hypot(H, up_a), scale * np.hypot(H, up_b)
        if np.isfinite(seabed) and rough:
            T_a = np.where((p_a < ON_BED) & (up_a > -(ON_BED**0.5)), np.nan, T_a)
            T_b = np.where((p_b < ON_BED) & (up_b > -(ON_BED**0.5)), np.nan, T_b)
    return Statics(T_a, T_b, force_a, force_b, shape)


def _root(grows: Callable[[np.ndarray], np.ndarray], low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Where a function that grows with u passes zero, between low and high (k,): by halving."""
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        above = grows(middle) > 0.0
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return 0.5 * (low + high)


def _hanging(h: np.ndarray, v: np.ndarray, e: np.ndarray, share: np.ndarray) -> tuple[np.ndarray, ...]:
    """x and z (k, n), then H and the upward parts of the pulls at ends a and b (k,), of free-hanging lines."""

    def excess(u: np.ndarray) -> np.ndarray:
        t = np.exp(u)
        return (h * np.sinh(t) / (t + 0.5 * e)) ** 2 + (2.0 * v / (2.0 + e / np.tanh(t))) ** 2 - 1.0

    possible = (e > 0.0) | (np.hypot(h, v) < 1.0)
    t = np.exp(_root(excess, np.full_like(h, LOW), np.full_like(h, HIGH)))
    t = np.where(possible & np.isfinite(h), t, np.nan)
    H, V = h / (2.0 * t + e), v / (2.0 * np.tanh(t) + e)
    s = share - 0.5
    H_, V_, e_ = H[:, None], V[:, None], e[:, None]
    x = H_ * (np.arcsinh((V_ + s) / H_) - np.arcsinh((V_ - 0.5) / H_)) + e_ * H_ * share
    z = np.hypot(H_, V_ + s) - np.hypot(H_, V_ - 0.5) + e_ * (V_ * share + 0.5 * (s * s - 0.25))
    return x, z, H, V - 0.5, -(V + 0.5)


def _lying(
    h: np.ndarray, e: np.ndarray, p_a: np.ndarray, p_b: np.ndarray, share: np.ndarray, lies: np.ndarray
) -> tuple[np.ndarray, ...]:
    """The same of lines that lie on a bed at p_a and p_b below their ends: two hanging parts of one H, and what lies.

    A part that hangs from p above the bed is s long, with hypot(H, s) = y and e y^2 / 2 + y = H + e H^2 / 2 + p.
    """
    h, e, p_a, p_b, share = (one[lies] for one in (h, e, p_a, p_b, share))

    def part(H: np.ndarray, p: np.ndarray) -> np.ndarray:
        C = H + 0.5 * e * H * H + p
        y = 2.0 * C / (1.0 + np.sqrt(1.0 + 2.0 * e * C))
        return np.sqrt(np.maximum(y * y - H * H, 0.0))

    def excess(u: np.ndarray) -> np.ndarray:
        H = np.exp(u)
        s_a, s_b = part(H, p_a), part(H, p_b)
        return H * (np.arcsinh(s_a / H) + np.arcsinh(s_b / H)) + (1.0 - s_a - s_b) + e * H - h

    H = np.exp(_root(excess, np.full_like(h, LOW), np.full_like(h, HIGH)))
    s_a, s_b = part(H, p_a), part(H, p_b)
    H_, e_ = H[:, None], e[:, None]
    from_a, from_b = np.maximum(s_a[:, None] - share, 0.0), np.maximum(share - (1.0 - s_b[:, None]), 0.0)
    lying = np.clip(share, s_a[:, None], 1.0 - s_b[:, None]) - s_a[:, None]
    x_a = H * np.arcsinh(s_a / H)
    x = x_a[:, None] - H_ * np.arcsinh(from_a / H_) + lying + H_ * np.arcsinh(from_b / H_) + e_ * H_ * share
    x[excess(np.log(H)) > HEAP] = np.nan  # more of it lies there than has room: its tension is known, its shape is not
    z = sum(np.hypot(H_, s) - H_ + 0.5 * e_ * s * s for s in (from_a, from_b)) - p_a[:, None]
    return x, z, H, -s_a, -s_b
