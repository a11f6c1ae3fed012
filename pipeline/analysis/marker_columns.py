"""What the columns of a table of markers mean, by their names: `time [s]`, `position[3,0] [m]`, `z12 (mm)`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
TIMES = {"s": "s", "ms": "ms", "us": "us", "µs": "us", "μs": "us", "ns": "ns"}
# `time [s]`, `x1[mm]` or `x1_mm`; what stands in brackets without a space before is a unit only if it is letters.
_UNIT = re.compile(
    r"\s+[\[(](?P<spaced>[^\])]*)[\])]$|[\[(](?P<joined>[a-zµμ]+)[\])]$|_(?P<suffix>mm|cm|ms|us|ns|m|s)$", re.IGNORECASE
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
_LABEL = re.compile(r"(marker|point|node|label|id|index|name|number)([ ._-]*(id|no|nr|name|number|index|label))?", re.I)
_LONE_FLAG = re.compile(r"valid|visible", re.IGNORECASE)
EXPECTED = (
    "expected a column of time, and for each marker its x, y and z: `time [s]`, `x1 [mm]`, `marker_1_x` or "
    "`position[0,0] [m]`; or a row for each marker: `time`, `marker`, `x`, `y`, `z`"
)


@dataclass(frozen=True)
class Place:
    """A coordinate's column, and what makes its numbers metres."""

    column: int
    metres: float


@dataclass
class Cable:
    """The columns of one cable. place: by marker's number and axis. flag: column by number.

    is_ned: the names say so. units: of its columns, "" where there is none, each with the first name that has it.
    """

    place: dict[tuple[int, int], Place] = field(default_factory=dict)
    flag: dict[int, int] = field(default_factory=dict)
    is_ned: bool = False
    units: dict[str, str] = field(default_factory=dict)

    @property
    def numbers(self) -> list[int]:
        """The markers' numbers in order."""
        return sorted({number for number, _ in self.place})


@dataclass
class Columns:
    """What the columns mean. time: column, and unit by its name, None where there is none. cables: by prefix.

    label: the column that names the marker where each has its own row, whose coordinates are then those of marker 0.
    """

    time: tuple[int, str | None] | None = None
    label: int | None = None
    cables: dict[str, Cable] = field(default_factory=dict)


def understand(names: Sequence[str]) -> Columns:
    """The columns by their names; what is not understood is left out.

    Raises ValueError with what is missing and the names there are.
    """
    columns = Columns()
    for index, name in enumerate(names):
        _take(columns, index, name.strip())
    have = f"the columns are {', '.join(names[:8])}{', ...' if len(names) > 8 else ''}; {EXPECTED}"
    if not columns.cables:
        _take_rows(columns, names)
    if columns.time is None:
        raise ValueError(f"no column of time; {have}")
    columns.cables = {prefix: cable for prefix, cable in columns.cables.items() if cable.place}
    if not columns.cables:
        raise ValueError(f"no columns of markers; {have}")
    for prefix, cable in columns.cables.items():
        for number in cable.numbers:
            if lacking := [axis for axis in range(3) if (number, axis) not in cable.place]:
                marker = f"marker {number}{f' of {prefix}' if len(columns.cables) > 1 and prefix else ''}"
                raise ValueError(f"{marker} has no {', '.join('xyz'[axis] for axis in lacking)}; {have}")
        if len(cable.units) > 1:
            found = ", ".join(
                f"'{name}' {f'in {unit}' if unit else 'without a unit'}" for unit, name in cable.units.items()
            )
            raise ValueError(f"lengths in different units: {found}; give all columns the same unit")
    return columns


def _split(name: str) -> tuple[str, str]:
    """A column's name without its unit, and the unit in small letters."""
    unit = _UNIT.search(name)
    text = (unit["spaced"] or unit["joined"] or unit["suffix"] or "").strip().lower() if unit else ""
    return (name[: unit.start()], text) if unit else (name, "")


def _take(columns: Columns, index: int, name: str) -> None:
    bare, text = _split(name)
    if _TIME.fullmatch(bare) and columns.time is None:
        columns.time = (index, TIMES[_known(name, text, TIMES)] if text else None)
    elif place := next(filter(None, (pattern.fullmatch(bare) for pattern in _PLACES)), None):
        prefix = place.groupdict().get("body") or ""
        cable = columns.cables.setdefault(prefix, Cable())
        _place(cable, (int(place["number"]), _AXES[place["axis"].lower()]), index, name, text)
        cable.is_ned |= place["axis"].lower() in ("0", "1", "2", "north", "east", "down")
    elif flag := _FLAG.fullmatch(bare):
        prefix, number = flag["body"] or "", int(flag["number"] or flag["only"])
        columns.cables.setdefault(prefix, Cable()).flag[number] = index


def _place(cable: Cable, key: tuple[int, int], index: int, name: str, unit: str) -> None:
    if key in cable.place:
        raise ValueError(f"column '{name}' is a second {'xyz'[key[1]]} of marker {key[0]}")
    cable.place[key] = Place(index, LENGTHS[_known(name, unit, LENGTHS)] if unit else 1.0)
    cable.units.setdefault(unit, name)


def _take_rows(columns: Columns, names: Sequence[str]) -> None:
    """A table with a row for each marker: x, y and z without a number, and a column that names the marker."""
    cable = Cable()
    for index, name in enumerate(names):
        bare, text = _split(name.strip())
        if bare.lower() in _AXES and not bare.isdigit():
            _place(cable, (0, _AXES[bare.lower()]), index, name, text)
            cable.is_ned |= bare.lower() in ("north", "east", "down")
        elif _LONE_FLAG.fullmatch(bare):
            cable.flag[0] = index
        elif _LABEL.fullmatch(bare) and columns.label is None:
            columns.label = index
    if columns.label is not None and cable.place:
        columns.cables[""] = cable


def _known(name: str, unit: str, known: dict[str, float] | dict[str, str]) -> str:
    if unit not in known:
        raise ValueError(f"column '{name}': unit '{unit}' is not known; use one of {', '.join(known)}")
    return unit
