"""A floating line in steady tow between two boats abeam, its equations integrated; Bhattacharya et al. 2011, eq. 9.

Lengths over the line's L, forces over c v^power L. From the apex, where the line lies across the tow, phi turns towards
it: dT/ds = along(phi), T dphi/ds = across(phi), which is eq. 9 with any law of drag and without the closed form.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, exp, log, sin

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from pipeline.analysis.coverage.drag import Drag

RELATIVE = 1e-11  # of the integration: the greatest sweep is flat, so that its place is known to the root of this
SLACKEST, TAUTEST = 1e-4, 1e4  # tensions at the apex between which a separation is looked for


@dataclass(frozen=True)
class Tow:
    """separation: D/L. force: on each boat, |f_0| / (c v^power L). angle: of the force from across the tow [rad]."""

    separation: float
    force: float
    angle: float


def tow(drag: Drag, apex: float) -> Tow:
    """The tow whose tension at the apex is this, over c v^power L."""
    return _tow(_integrate(drag, apex).y[:, -1])


def tow_at(drag: Drag, separation: float) -> Tow:
    """The tow at a separation D/L. Raises ValueError where it is not between 0 and 1."""
    return tow(drag, _apex_at(drag, separation))


def shape(drag: Drag, separation: float, points: int) -> np.ndarray:
    """The line at a separation D/L: (points, 2) across and along the tow over L, from one end to the other, apex 0, 0.

    points: odd, so that the apex is one. Raises ValueError where the separation is not between 0 and 1.
    """
    found = _integrate(drag, _apex_at(drag, separation), dense=True)
    half = found.sol(np.linspace(0.0, 0.5, points // 2 + 1))[2:].T
    return np.concatenate([half[:0:-1] * (-1.0, 1.0), half])


def _tow(end: np.ndarray) -> Tow:
    T, phi, x, _ = end
    return Tow(2.0 * float(x), float(T), float(phi))


def _integrate(drag: Drag, apex: float, dense: bool = False):
    def change(_, state):
        T, phi = state[0], state[1]
        across, along = drag.parts(phi)
        return along, across / T, cos(phi), sin(phi)

    start = (apex, 0.0, 0.0, 0.0)
    return solve_ivp(change, (0.0, 0.5), start, "DOP853", rtol=RELATIVE, atol=1e-14, dense_output=dense)


def _apex_at(drag: Drag, separation: float) -> float:
    """Where the half width, which grows with the tension, is half of the separation."""
    least, most = (tow(drag, apex).separation for apex in (SLACKEST, TAUTEST))
    if not least < separation < most:
        raise ValueError(f"separation is {separation:g} of the length; expected {least:.2g} to {most:.9g}")
    ends = log(SLACKEST), log(TAUTEST)
    return exp(float(brentq(lambda e: tow(drag, exp(e)).separation - separation, *ends, xtol=1e-13)))  # pyright: ignore
