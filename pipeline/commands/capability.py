"""towline capability: the wind up to which thrusters hold a ship, per heading, intact and after each failure."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from rich.table import Table

from pipeline.commands.output import console, print_json, progress_bar
from pipeline.errors import TowlineError

if TYPE_CHECKING:
    from pipeline.capability.limits import Capability

PICTURES = (".png", ".svg", ".pdf")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    parser.add_argument(
        "ship", type=Path, metavar="SHIP.yaml", help="thrusters, and a table of loads or a vessel and its weather"
    )
    parser.add_argument("--out", "-o", type=Path, metavar="F", help=f"draw the rose ({', '.join(PICTURES)})")
    parser.add_argument("--overwrite", action="store_true", help="replace the picture if it exists")


def _shown(found: Capability, case: str, heading: int) -> str:
    return f"{'>= ' if found.is_more[case][heading] else ''}{found.winds[case][heading]:.2f}"


def _print(found: Capability) -> None:
    table = Table(title="wind [m/s] up to which position is held; at >= higher winds were not tried")
    for column in ("from [deg]", *found.winds, "worst failure"):
        table.add_column(column, justify="right")
    for h, heading in enumerate(found.headings):
        worst = (found.worst[h] or "none") if found.worst else ""
        table.add_row(f"{heading:g}", *(_shown(found, case, h) for case in found.winds), worst)
    console().print(table)
    if any(found.worst):
        least = {case: float(found.winds[case].min()) for case in set(found.worst) if case}
        case = min(least, key=lambda name: least[name])
        above = (
            f"is lost above {least[case]:.2f} m/s of wind" if least[case] else "is not held at the least tabulated wind"
        )
        console().print(f"the worst single failure is {case}: from one heading at least, position {above}")


def command(arguments: argparse.Namespace) -> int:
    """Compute, draw and print."""
    from pipeline.capability.limits import capability  # with numba, which takes a while to load
    from pipeline.capability.ship import read_ship

    out: Path | None = arguments.out
    if out is not None and out.suffix not in PICTURES:
        raise TowlineError(f"{out}: '{out.suffix}' is no kind of picture known here; expected {', '.join(PICTURES)}")
    if out is not None and out.exists() and not arguments.overwrite:
        raise TowlineError(f"{out} exists; give another name with --out, or --overwrite")
    ship = read_ship(arguments.ship)
    with progress_bar("cases", 1.0 + len(ship.failures), quiet=arguments.json) as progress:
        found = capability(ship, progress)
    if out is not None:
        from pipeline.capability.rose import draw

        try:
            draw(found, arguments.ship.stem, out)
        except OSError as error:
            raise TowlineError(f"{out}: cannot be written: {error.strerror or error}") from error
    if arguments.json:
        print_json(
            {
                "heading_deg": found.headings.tolist(),
                "limiting_wind_m_s": {case: winds.tolist() for case, winds in found.winds.items()},
                "beyond_table": {case: more.tolist() for case, more in found.is_more.items()},
                "worst_failure": found.worst,
            }
        )
    else:
        _print(found)
    return 0
