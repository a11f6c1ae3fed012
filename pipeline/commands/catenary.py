"""towline catenary: the static line between two points, in closed form."""

from __future__ import annotations

import argparse

from rich.table import Table

from components.tether.catenary.hang import hang
from pipeline.commands.output import console, print_json
from pipeline.errors import TowlineError
from pipeline.quantities import si_value

# What it means where there is no sea bed but at most one at the level of the lower end.
TITLES = {"touches_seabed": "hangs below its lower end"}
UNITS = {"H_N": "N", "V_a_N": "N", "V_b_N": "N", "C_per_m": "1/m", "sag_m": "m", "touches_seabed": ""}
ARGUMENTS = (
    ("length", "m", "unstretched length"),
    ("weight", "N/m", "weight in water per length"),
    ("span", "m", "horizontal distance of the ends"),
    ("rise", "m", "height of end b above end a"),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    for name, unit, text in ARGUMENTS:
        parser.add_argument(f"--{name}", required=True, metavar=unit.upper(), help=f"{text} [{unit}]")
    parser.add_argument("--ea", metavar="N", help="axial stiffness [N] (default: inextensible)")


def _si(name: str, text: str, unit: str) -> float:
    try:
        return si_value(text, unit, bare=True)
    except ValueError as error:
        raise TowlineError(f"--{name}: {error}") from error


def command(arguments: argparse.Namespace) -> int:
    """Solve and print it."""
    length, weight, span, rise = (_si(name, getattr(arguments, name), unit) for name, unit, _ in ARGUMENTS)
    ea = None if arguments.ea is None else _si("ea", arguments.ea, "N")
    try:
        line = hang(length, weight, span, rise, ea)
    except ValueError as error:
        raise TowlineError(f"no such line: {error}") from error
    values = {name: getattr(line, name) for name in UNITS}
    if arguments.json:
        print_json(values)
        return 0
    table = Table()
    for column in ("", "value", "unit"):
        table.add_column(column)
    for name, value in values.items():
        shown = ("yes" if value else "no") if isinstance(value, bool) else f"{value:.9g}"
        table.add_row(TITLES.get(name, name), shown, UNITS[name])
    console().print(table)
    return 0
