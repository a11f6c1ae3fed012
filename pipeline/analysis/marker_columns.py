"""What the columns of a table of markers mean, by their names: `time [s]`, `position[3,0] [m]`, `z12 (mm)`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
TIMES_NS = {"s": 1e9, "ms": 1e6, "us": 1e3, "µs": 1e3, "ns": 1.0}
# `time [s]`, `x1[mm]` or `x1_mm`; what stands in brackets without a space before is a unit only if it is letters.
_UNIT = re.compile(
    r"\s+[\[(](?P<spaced>[^\])]*)[\])]$|[\[(](?P<joined>[a-zµ]+)[\])]$|_(?P<suffix>mm|cm|ms|us|ns|m|s)$", re.IGNORECASE
)
_TIME = re.compile(r"(sim_?|log_?|elapsed_?)?(t|time|timestamp|stamp|seconds)", re.IGNORECASE)
_AXES = {"x": 0, "y": 1, "z": 2, "north": 0, "east": 1, "down": 2, "0": 0, "1": 1, "2": 2}
_AXIS = "x|y|z|north|east|down"
_PLACES = (
    re.compile(r"(?P<body>position|nodes)\[(?P<number>\d+),(?P<axis>[012])\]"),  # as towline export writes them
    re.compile(rf"(?P<axis>{_AXIS})[ ._:-]*\[?(?P<number>\d+)\]?", re.IGNORECASE),
    re.compile(rf"(?P<body>.*?)[ ._:-]*\[?(?P<number>\d+)\]?[ ._:-]*(?P<axis>{_AXIS})", re.IGNORECASE),
)
_FLAG = re.compile(
    r"(?P<body>.*?)[ ._:-]*\[?(?P<number>\d+)\]?[ ._:-]*(valid|visible)|(valid|visible)[ ._:-]*\[?(?P<only>\d+)\]?",
    re.IGNORECASE,
)
EXPECTED = (
    "expected a column of time, and for each marker its x, y and z: "
    "`time [s]`, `x1 [mm]`, `marker_1_x` or `position[0,0] [m]`"
)


@dataclass
class Columns:
    """Where everything stands. place: column and scale to metres by marker's number and axis. flag: column by number.

    is_ned: the names say so. bare: columns of lengths without a unit.
    """

    time: tuple[int, float] | None = None  # column, scale to ns
    place: dict[tuple[int, int], tuple[int, float]] = field(default_factory=dict)
    flag: dict[int, int] = field(default_factory=dict)
    is_ned: bool = False
    bare: int = 0

    @property
    def numbers(self) -> list[int]:
        """The markers' numbers in order."""
        return sorted({number for number, _ in self.place})


def understand(names: Sequence[str]) -> Columns:
    """The columns by their names; what is not understood is left out.

    Raises ValueError with what is missing and the names there are.
    """
    columns = Columns()
    for index, name in enumerate(names):
        _take(columns, index, name.strip())
    have = f"the columns are {', '.join(names[:8])}{', ...' if len(names) > 8 else ''}; {EXPECTED}"
    if columns.time is None:
        raise ValueError(f"no column of time; {have}")
    if not columns.place:
        raise ValueError(f"no columns of markers; {have}")
    for number in columns.numbers:
        if lacking := [axis for axis in range(3) if (number, axis) not in columns.place]:
            raise ValueError(f"marker {number} has no {', '.join('xyz'[axis] for axis in lacking)}; {have}")
    return columns


def _take(columns: Columns, index: int, name: str) -> None:
    unit = _UNIT.search(name)
    bare = name[: unit.start()] if unit else name
    text = (unit["spaced"] or unit["joined"] or unit["suffix"] or "").strip().lower() if unit else ""
    if _TIME.fullmatch(bare) and columns.time is None:
        columns.time = (index, _scale(name, text or "s", TIMES_NS))
    elif place := next(filter(None, (pattern.fullmatch(bare) for pattern in _PLACES)), None):
        key = (int(place["number"]), _AXES[place["axis"].lower()])
        if key in columns.place:
            raise ValueError(f"column '{name}' is a second {'xyz'[key[1]]} of marker {key[0]}")
        columns.place[key] = (index, _scale(name, text or "m", LENGTHS))
        columns.bare += not text
        columns.is_ned |= place["axis"].lower() in ("0", "1", "2", "north", "east", "down")
    elif flag := _FLAG.fullmatch(bare):
        columns.flag[int(flag["number"] or flag["only"])] = index


def _scale(name: str, unit: str, known: dict[str, float]) -> float:
    if unit not in known:
        raise ValueError(f"column '{name}': unit '{unit}' is not known; use one of {', '.join(known)}")
    return known[unit]
