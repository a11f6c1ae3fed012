"""towline catenary: the static line between two points, in closed form."""

from __future__ import annotations

import argparse
from typing import Any

from rich.table import Table

from components.tether.catenary.hang import Vector, hang
from pipeline.commands.output import console, print_json
from pipeline.errors import TowlineError
from pipeline.quantities import si_value

# What it means where no seabed is given, which could then be at most at the level of the lower end.
WITHOUT_SEABED = "hangs below its lower end"
UNITS = {"H_N": "N", "V_a_N": "N", "V_b_N": "N", "C_per_m": "1/m", "sag_m": "m", "touches_seabed": ""}
ON_SEABED = {"grounded_m": "m"}
WORLD_FORCES = {"force_a_N": "N", "force_b_N": "N"}
NEEDED = (
    ("length", "m", "unstretched length"),
    ("span", "m", "horizontal distance of the ends, end b north of end a"),
    ("rise", "m", "height of end b above end a"),
)
OPTIONAL = (
    ("weight", "N/m", "weight in water per length"),
    ("ea", "N", "axial stiffness (default: inextensible)"),
    ("seabed", "m", "depth of a level seabed below end a (default: none)"),
    ("friction", "1", "Coulomb's friction on it, the end on the seabed being the anchor (default: 0)"),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    for name, unit, text in NEEDED:
        parser.add_argument(f"--{name}", required=True, metavar=unit.upper(), help=f"{text} [{unit}]")
    for name, unit, text in OPTIONAL:
        parser.add_argument(f"--{name}", metavar=unit.upper(), help=f"{text} [{unit}]")
    parser.add_argument(
        "--load",
        metavar="N/M,N/M,N/M",
        help="all load per length instead of --weight: north, east, down [N/m], as in --load=0.4,0,0.9",
    )


def _si(name: str, text: str, unit: str) -> float:
    try:
        return si_value(text, unit, bare=True)
    except ValueError as error:
        raise TowlineError(f"--{name}: {error}") from error


def _load(arguments: argparse.Namespace) -> float | Vector:
    if (arguments.weight is None) == (arguments.load is None):
        raise TowlineError("give exactly one of --weight N/M and --load N/M,N/M,N/M")
    if arguments.load is None:
        return _si("weight", arguments.weight, "N/m")
    parts = arguments.load.split(",")
    if len(parts) != 3:
        raise TowlineError(f"--load: {len(parts)} numbers; expected north,east,down in N/m, such as 0.4,0,0.9")
    north, east, down = (_si("load", part.strip(), "N/m") for part in parts)
    return north, east, down


def _units(arguments: argparse.Namespace) -> dict[str, str]:
    """What is told and its units: the seabed's and the world's numbers only where they were asked about."""
    on_seabed = {} if arguments.seabed is None else ON_SEABED
    forces = {} if arguments.seabed is None and arguments.load is None else WORLD_FORCES
    return {**UNITS, **on_seabed, **forces}


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, tuple):
        return ", ".join(f"{number:.9g}" for number in value)
    return f"{value:.9g}"


def command(arguments: argparse.Namespace) -> int:
    """Solve and print it."""
    length, span, rise = (_si(name, getattr(arguments, name), unit) for name, unit, _ in NEEDED)
    load = _load(arguments)
    ea = None if arguments.ea is None else _si("ea", arguments.ea, "N")
    seabed = None if arguments.seabed is None else _si("seabed", arguments.seabed, "m")
    friction = 0.0 if arguments.friction is None else _si("friction", arguments.friction, "1")
    try:
        line = hang(length, load, span, rise, ea, seabed, friction)
    except ValueError as error:
        raise TowlineError(f"no such line: {error}") from error
    units = _units(arguments)
    values = {name: getattr(line, name) for name in units}
    if arguments.json:
        print_json(values)
        return 0
    titles = {"touches_seabed": WITHOUT_SEABED} if seabed is None else {}
    table = Table()
    for column in ("", "value", "unit"):
        table.add_column(column)
    for name, value in values.items():
        table.add_row(titles.get(name, name), _shown(value), units[name])
    console().print(table)
    return 0
