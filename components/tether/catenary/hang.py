"""One static line from its length, load and ends, for the command line and for notebooks."""

from dataclasses import dataclass
from math import hypot, inf, isfinite

from components.tether.catenary.frame import Frame, hanging_frame
from components.tether.catenary.line import Rest, end_tensions, neutral, parameter, rest, sag
from components.tether.catenary.status import NEUTRAL_SLACK, TEXT

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class HangingLine:
    """What holds a line between two points. "Up" is against the load, "horizontal" across it.

    H_N: horizontal tension [N]; with seabed friction that where it touches down. V_a_N, V_b_N: upward force [N] with
    which what holds end a (b) carries the line; a negative one holds it down. C_per_m: Drupt et al. 2022's catenary
    parameter w/H [1/m] (eq. 4), the largest double for a vertical line. sag_m: depth [m] of the lowest point below the
    lower end (H of their eq. 3), 0 where that end is the lowest point. touches_seabed: whether a part lies on the
    seabed; where none is given, whether the line hangs below its lower end, so that it would touch a bottom at that
    end's level. grounded_m: unstretched length on the seabed [m]. force_a_N, force_b_N: of the line on what holds its
    ends [N], north, east and down, where end b is north of end a.
    """

    H_N: float
    V_a_N: float
    V_b_N: float
    C_per_m: float
    sag_m: float
    touches_seabed: bool
    grounded_m: float
    force_a_N: Vector
    force_b_N: Vector


def hang(
    length: float,
    load: float | Vector,
    span: float,
    rise: float,
    ea: float | None = None,
    seabed: float | None = None,
    friction: float = 0.0,
) -> HangingLine:
    """The static line whose end b is `span` [m] >= 0 north of end a and `rise` [m] above it.

    length: unstretched [m]; load: the weight in water per length [N/m], negative for a buoyant line (its sag is then
    measured up from the higher end), or all load as a vector, NED; ea: axial stiffness [N], none for inextensible;
    seabed: its depth below end a [m], none for no seabed, which takes a vertical load; friction: Coulomb's, on it.
    Raises ValueError where the figures are impossible or leave the line's shape or tension undetermined, saying which
    and why.
    """
    q: Vector = load if isinstance(load, tuple) else (0.0, 0.0, load)
    _check(length, q, span, rise, ea, seabed, friction)
    flexibility = 0.0 if ea is None else 1.0 / ea
    frame, w, across, up = hanging_frame(*q, span, 0.0, -rise)
    if w == 0.0:
        status, T, _ = neutral(across / length, 0.0, flexibility)
        _refuse(status, length, span, rise)
        pull = _vector(frame, T, 0.0)
        level = hypot(pull[0], pull[1])
        return HangingLine(level, pull[2], -pull[2], 0.0, 0.0, False, 0.0, pull, _vector(frame, -T, 0.0))
    p_a, p_b = (inf, inf) if seabed is None else (seabed / length, (seabed + rise) / length)
    scale = w * length
    status, line = rest(across / length, up / length, scale * flexibility, p_a, p_b, friction)
    _refuse(status, length, span, rise)
    if not isfinite(scale * (abs(line.s_a) + abs(line.s_b) + line.H)):
        raise ValueError("the figures are too far apart in size: the line's force is no finite number")
    sense = -1.0 if q[0] == q[1] == 0.0 and q[2] < 0.0 else 1.0
    return _described(frame, w, length, line, sense, seabed)


def _described(frame: Frame, w: float, length: float, line: Rest, sense: float, seabed: float | None) -> HangingLine:
    """sense: -1 for a buoyant line, whose V count upwards in the world all the same."""
    scale = w * length
    H_a, H_b = end_tensions(line)
    depth = length * (line.p_a + min(0.0, line.v) if line.touches else sag(line.H, line.V, line.e))
    below = sense * depth > 0.0
    return HangingLine(
        H_N=scale * line.H,
        V_a_N=sense * scale * line.s_a,
        V_b_N=sense * scale * line.s_b,
        C_per_m=parameter(scale * line.H, w),
        sag_m=depth,
        touches_seabed=bool(below if seabed is None else line.touches),
        grounded_m=length * (1.0 - line.s_a - line.s_b) if line.touches else 0.0,
        force_a_N=_vector(frame, scale * H_a, -scale * line.s_a),
        force_b_N=_vector(frame, -scale * H_b, -scale * line.s_b),
    )


def _vector(frame: Frame, along: float, up: float) -> Vector:
    return (
        along * frame.along_x + up * frame.up_x,
        along * frame.along_y + up * frame.up_y,
        along * frame.along_z + up * frame.up_z,
    )


def _check(
    length: float, q: Vector, span: float, rise: float, ea: float | None, seabed: float | None, friction: float
) -> None:
    figures = {"length": length, "span": span, "rise": rise, "ea": ea or 0.0, "seabed": seabed or 0.0}
    for name, value in {**figures, "friction": friction, "load": sum(q)}.items():
        if not isfinite(value):
            raise ValueError(f"{name} is {value}: it must be a finite number")
    if length <= 0.0 or span < 0.0 or (ea is not None and ea <= 0.0):
        raise ValueError(f"length {length:g} m and ea {ea} N must be positive, span {span:g} m must not be negative")
    if friction < 0.0:
        raise ValueError(f"friction is {friction:g}: it must not be negative")
    if friction > 0.0 and seabed is None:
        raise ValueError(f"friction is {friction:g} without a seabed: its depth must be given")
    if seabed is not None and (q[0] != 0.0 or q[1] != 0.0 or q[2] <= 0.0):
        raise ValueError(f"load is ({q[0]:g}, {q[1]:g}, {q[2]:g}) N/m: on a seabed it must be vertical and down")


def _refuse(status: int, length: float, span: float, rise: float) -> None:
    if status:
        chord = hypot(span, rise)
        excess = "" if status == NEUTRAL_SLACK else f" ({chord - length:+.3g} m)"
        raise ValueError(f"ends {chord:.9g} m apart on a line of {length:.9g} m{excess}: {TEXT[status]}")
