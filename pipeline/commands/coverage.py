"""towline coverage: the water that a line swept in a log, and how much of an oil patch it took."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline.commands.output import console, print_json, warn
from pipeline.errors import TowlineError
from pipeline.log.reader import Log, open_log

if TYPE_CHECKING:
    import numpy as np

HISTORY = 101  # times at which --json tells what was taken of a patch


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    parser.add_argument("log", type=Path, help="of a run with a line, or with two boats")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--line", metavar="NAME", help="the line's channel (default: the only one that has nodes)")
    text = "instead: the straight line between two positions, such as left.hook_a.position"
    which.add_argument("--between", nargs=2, metavar=("A", "B"), help=text)
    parser.add_argument(
        "--patch", nargs="+", metavar="N,E", help="corners of an oil patch in turn, at the first time [m]"
    )
    parser.add_argument(
        "--drift", metavar="N,E", help="velocity of the water and what floats on it [m/s] (default: 0,0)"
    )


def pair(text: str, option: str) -> tuple[float, float]:
    """North and east. Raises TowlineError if the text is no pair of numbers."""
    try:
        north, east = (float(one) for one in text.split(","))
    except ValueError as error:
        raise TowlineError(f"--{option}: '{text.strip()}' is no pair of numbers; expected such as 12.5,-3") from error
    if not abs(north) + abs(east) < float("inf"):
        raise TowlineError(f"--{option}: '{text.strip()}' is not finite")
    return north, east


def command(arguments: argparse.Namespace) -> int:
    """Read, sum up and print."""
    drift = pair(arguments.drift, "drift") if arguments.drift else (0.0, 0.0)
    corners = [pair(text, "patch") for text in arguments.patch or ()]
    with open_log(arguments.log) as log:
        if log.warning:
            warn(log.warning)
        found = measured(log, arguments.line, arguments.between, drift, corners)
    if arguments.json:
        print_json(found)
    else:
        _print(found)
    return 0


def measured(
    log: Log,
    line: str | None,
    between: list[str] | None,
    drift: tuple[float, float],
    corners: list[tuple[float, float]],
) -> dict[str, Any]:
    """The keys of --json."""
    import numpy as np

    from pipeline.analysis.coverage import patch, swept  # shapely takes a while to import

    if between:
        name, t, shapes = swept.straight_shapes(log, (between[0], between[1]), drift)
    else:
        name, t, shapes = swept.line_shapes(log, line, drift)
    area = swept.area(shapes)
    span = float(t[-1] - t[0])
    found = {
        "line": name,
        "duration_s": span,
        "swept_m2": area,
        "swept_by_mouth_m2": swept.area(shapes[:, [0, -1]]),
        "rate_m2_s": area / span,
        "separation_m": _separation(shapes),
    }
    if corners:
        taken = patch.capture(patch.patch_of(corners), t, shapes)
        found |= {"patch_m2": taken.area, "captured_m2": taken.captured, "captured": taken.captured / taken.area}
        found |= {"first_s": taken.first, "last_s": taken.last}
        times = np.linspace(t[0], t[-1], HISTORY)
        found["history"] = {"t_s": times.tolist(), "captured_m2": taken.at(times).tolist()}
    return found


def _separation(shapes: np.ndarray) -> float:
    """Mean distance of the ends [m]."""
    return float((((shapes[:, -1] - shapes[:, 0]) ** 2).sum(axis=1) ** 0.5).mean())


def _print(found: dict[str, Any]) -> None:
    out = console()
    out.print(
        f"{found['line']} swept {found['swept_m2']:.5g} m² in {found['duration_s']:.5g} s "
        f"({found['rate_m2_s']:.4g} m²/s), its mouth {found['swept_by_mouth_m2']:.5g} m², "
        f"{found['separation_m']:.4g} m wide on the average"
    )
    if "patch_m2" in found:
        when = "" if found["first_s"] is None else f", from {found['first_s']:.5g} to {found['last_s']:.5g} s"
        share = 100.0 * found["captured"]
        out.print(f"of the patch's {found['patch_m2']:.5g} m² it took {found['captured_m2']:.5g} ({share:.3g} %){when}")
