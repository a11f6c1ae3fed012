"""Closed forms of a floating line in steady tow, for the laws of drag that have one.

u: half the line over the catenary's length, of which all else follows. With a load that is uniform along the tow
(linear with c_V = c_S, isotropic quadratic) and with quadratic drag across only, the line is a catenary,
D/L = u / sinh u; with linear drag across only it is y = -a ln cos(x/a), D/L = gd(u) / u.
"""

from __future__ import annotations

from math import atan, sinh, tanh

from scipy.optimize import brentq

from pipeline.analysis.coverage.drag import ACROSS, EQUAL, QUADRATIC, QUADRATIC_ACROSS, Drag
from pipeline.analysis.coverage.optimum import Optimum, rate
from pipeline.analysis.coverage.steady import Tow


def tow(drag: Drag, u: float) -> Tow:
    """The tow, over L and c v^power L as in steady.py. Raises ValueError for a law without a closed form."""
    turned = atan(sinh(u))  # of a catenary and of its dual alike: the tangent's turn from apex to end
    if drag in (EQUAL, QUADRATIC):
        return Tow(u / sinh(u), 0.5 / tanh(u), turned)
    if drag == QUADRATIC_ACROSS:
        return Tow(u / sinh(u), 0.5 / sinh(u), turned)
    if drag == ACROSS:
        return Tow(turned / u, 0.5 / u, turned)
    raise ValueError(f"no closed form of {drag.name}")


def u_at(drag: Drag, separation: float) -> float:
    """The u of a separation D/L between 0 and 1."""
    return float(brentq(lambda u: tow(drag, u).separation - separation, 1e-9, 650.0, xtol=1e-14))  # pyright: ignore


def optimum(drag: Drag) -> Optimum | None:
    """Where the rate's derivative vanishes: u tanh u = 1; u = 2 tanh u; 1/u + 1/sinh 2u = coth u; nowhere."""
    if drag == ACROSS:
        return None  # the rate is 2 gd(u), which grows to pi as D/L goes to nothing
    slopes = {
        EQUAL: lambda u: u * tanh(u) - 1.0,
        QUADRATIC_ACROSS: lambda u: u - 2.0 * tanh(u),
        QUADRATIC: lambda u: 1.0 / u + 1.0 / sinh(2.0 * u) - 1.0 / tanh(u),
    }
    if drag not in slopes:
        raise ValueError(f"no closed form of {drag.name}")
    u = float(brentq(slopes[drag], 0.5, 5.0, xtol=1e-14))  # pyright: ignore
    best = tow(drag, u)
    return Optimum(best.separation, rate(drag, best))
