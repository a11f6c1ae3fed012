"""One static line from its length, weight and ends, for the command line and for notebooks."""

from dataclasses import dataclass
from math import hypot, inf, isfinite

from components.tether.catenary.line import neutral, parameter, rest, sag
from components.tether.catenary.status import NEUTRAL_SLACK, TEXT


@dataclass(frozen=True)
class HangingLine:
    """What holds a line that hangs free between two points.

    H_N: horizontal tension [N]. V_a_N, V_b_N: upward force [N] with which what holds end a (b) carries the line;
    their sum is its weight, and a negative one holds the line down. C_per_m: Drupt et al. 2022's catenary parameter
    w/H [1/m] (eq. 4), the largest double for a vertical line. sag_m: depth [m] of the lowest point below the lower
    end (H of their eq. 3), 0 where that end is the lowest point. touches_seabed: whether the line hangs below its
    lower end, so that it would touch a bottom at that end's level.
    """

    H_N: float
    V_a_N: float
    V_b_N: float
    C_per_m: float
    sag_m: float
    touches_seabed: bool


def hang(length: float, weight: float, span: float, rise: float, ea: float | None = None) -> HangingLine:
    """The static line over a horizontal span [m] >= 0 whose end b is `rise` [m] above end a.

    length: unstretched [m]; weight: in water per length [N/m], negative for a buoyant line (its sag is then measured
    up from the higher end); ea: axial stiffness [N], none for inextensible. Raises ValueError where the figures are
    impossible or leave the line's shape or tension undetermined, saying which and why.
    """
    for name, value in {"length": length, "weight": weight, "span": span, "rise": rise, "ea": ea or 0.0}.items():
        if not isfinite(value):
            raise ValueError(f"{name} is {value}: it must be a finite number")
    if length <= 0.0 or span < 0.0 or (ea is not None and ea <= 0.0):
        raise ValueError(f"length {length:g} m and ea {ea} N must be positive, span {span:g} m must not be negative")
    flexibility = 0.0 if ea is None else 1.0 / ea
    if weight == 0.0:
        return _without_weight(length, span, rise, flexibility)
    up = 1.0 if weight > 0.0 else -1.0
    scale = abs(weight) * length
    e = scale * flexibility
    status, _, H, V, s_a, s_b = rest(span / length, up * rise / length, e, inf, inf)
    _refuse(status, length, span, rise)
    if not isfinite(scale * (abs(s_a) + abs(s_b) + H)):
        raise ValueError("the figures are too far apart in size: the line's force is no finite number")
    depth = length * sag(H, V, e)
    return HangingLine(
        scale * H, up * scale * s_a, up * scale * s_b, parameter(scale * H, weight), depth, bool(up * depth > 0.0)
    )


def _without_weight(length: float, span: float, rise: float, flexibility: float) -> HangingLine:
    status, H, V = neutral(span / length, rise / length, flexibility)
    _refuse(status, length, span, rise)
    return HangingLine(H, -V, V, 0.0, 0.0, False)


def _refuse(status: int, length: float, span: float, rise: float) -> None:
    if status:
        chord = hypot(span, rise)
        excess = "" if status == NEUTRAL_SLACK else f" ({chord - length:+.3g} m)"
        raise ValueError(f"ends {chord:.9g} m apart on a line of {length:.9g} m{excess}: {TEXT[status]}")
