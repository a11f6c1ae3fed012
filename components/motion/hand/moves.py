"""The words of a programme ("slow sweep north", "fast circle north-down") and the numbers they stand for."""

from math import pi, sqrt

from components.motion.hand.programme import CIRCLE, EIGHT, REST, REVERSAL, SEGMENT, SWEEP

AXES = ("north", "east", "down")
KINDS = {"sweep": SWEEP, "reversal": REVERSAL, "circle": CIRCLE, "eight": EIGHT}

# Time of one cycle in units of reach/speed, speed being the fastest of the cycle.
CYCLE = {
    SWEEP: 7.5,  # there and back over both sides: 4 reaches of path, peak 15/8 of the mean (Flash and Hogan 1985)
    REVERSAL: 4.0,  # the same path at constant speed
    CIRCLE: pi,  # through home, the far side at the reach
    EIGHT: 2.0 * sqrt(2.0) * pi,  # (sin a, sin(2 a)/2), fastest at home
}
FORM = "expected 'rest' or '<slow|fast> <sweep|reversal|circle|eight> <axes>', axes such as north or east-down"


def directions(kind: int, words: str) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Unit vectors (3,), (3,) in NED along and across a move; raises ValueError for axes it does not have."""
    names = words.split("-")
    wanted = (2,) if kind in (CIRCLE, EIGHT) else (1, 2, 3)
    if len(set(names)) != len(names) or not set(names) <= set(AXES) or len(names) not in wanted:
        count = "two different ones" if wanted == (2,) else "up to three different ones"
        raise ValueError(f"its axes are '{words}': expected {count} of {', '.join(AXES)}, joined by -")
    units = [tuple(1.0 if axis == name else 0.0 for axis in AXES) for name in names]
    if len(wanted) == 1:
        return units[0], units[1]
    return tuple(sum(parts) / sqrt(len(units)) for parts in zip(*units, strict=True)), (0.0, 0.0, 0.0)


def segment(move: str, start_ns: int, duration: float, reach: float, speeds: dict[str, float]) -> list[float]:
    """The ten numbers of programme.py of a move that lasts `duration` [s].

    reach [m]: its farthest point from home; speeds [m/s] by name. Raises ValueError for a move that is none, or that
    does not fit into its duration once.
    """
    if move == "rest":
        return [start_ns, REST, 1.0, 0.0] + [0.0] * (SEGMENT - 4)
    words = move.split()
    if len(words) != 3 or words[0] not in speeds or words[1] not in KINDS:
        raise ValueError(FORM)
    kind = KINDS[words[1]]
    along, across = directions(kind, words[2])
    cycle = CYCLE[kind] * reach / speeds[words[0]]
    cycles = int(duration / cycle * (1.0 + 1e-12))  # a duration computed as n cycles may be rounded below them
    if cycles < 1:
        raise ValueError(f"{duration:g} s are too short for it: once at {speeds[words[0]]:g} m/s takes {cycle:.3g} s")
    scaled = [reach * number for number in (*along, *across)]
    return [start_ns, kind, cycle, cycles * cycle, *scaled]
