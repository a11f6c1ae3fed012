"""towline drag: which laws of drag the seen shape of a towed rope allows, with which ratio of their coefficients."""

from __future__ import annotations

import argparse
from math import isfinite, radians
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline.commands.coverage import pair
from pipeline.commands.output import console, print_json, warn
from pipeline.errors import TowlineError
from pipeline.log.reader import open_log
from pipeline.quantities import si_value

if TYPE_CHECKING:
    from pipeline.analysis.drag.fit import Fit, Judgement


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    parser.add_argument("log", type=Path, help="of a run in which boats see their rope (markers.rope_view)")
    text = "signals of a boat, and its view or -; twice (default: as the log's two views are wired)"
    parser.add_argument("--boat", nargs=3, action="append", metavar=("POSITION", "HEADING", "VIEW"), help=text)
    parser.add_argument("--hook", metavar="X,Y", help="where the boats hold the rope, ahead and starboard [m]")
    parser.add_argument("--length", metavar="L", help="of the rope [m] (default: the scenario's)")
    parser.add_argument("--noise", metavar="S", help="standard deviation of a point [m] (default: the view's)")
    parser.add_argument("--window", nargs=2, metavar=("FROM", "TO"), help="times to look at [s]")
    parser.add_argument("--drift", metavar="N,E", help="velocity of the water [m/s] (default: 0,0)")
    for name, what in (("pose-error", "new in each picture"), ("pose-bias", "the same in all")):
        text = f"deviation of the boats' measured positions [m] and headings [deg], {what}"
        parser.add_argument(f"--{name}", nargs=2, metavar=("M", "DEG"), help=text)
    parser.add_argument("--pulls", nargs=2, metavar=("A", "B"), help="signals of the ropes' forces on both boats, or -")
    parser.add_argument("--pull-error", metavar="PART", default="2%", help="relative deviation of these (default: 2%%)")


def command(arguments: argparse.Namespace) -> int:
    """Read, fit, compare and print."""
    from pipeline.analysis.drag import fit, recorded  # scipy takes a while to import
    from pipeline.analysis.drag.pictures import Errors

    error, bias = (_pose(arguments, name) for name in ("pose_error", "pose_bias"))
    if arguments.boat is not None and len(arguments.boat) != 2:
        raise TowlineError(f"--boat is given {len(arguments.boat)} times; expected twice, once for each boat")
    boats = tuple(recorded.Boat(*one) for one in arguments.boat or ())
    if boats and all(boat.view == recorded.NONE for boat in boats):
        raise TowlineError("--boat: neither has a view; expected one at least")
    window = None
    if arguments.window:
        window = tuple(_number(text, "s", "window", negative=True) for text in arguments.window)
    asked = recorded.Asked(
        boats=boats or None,  # pyright: ignore
        hook=pair(arguments.hook, "hook") if arguments.hook else (0.0, 0.0),
        length=None if arguments.length is None else _number(arguments.length, "m", "length"),
        noise=None if arguments.noise is None else _number(arguments.noise, "m", "noise"),
        window=window,  # pyright: ignore
        drift=pair(arguments.drift, "drift") if arguments.drift else (0.0, 0.0),
        pulls=None if arguments.pulls is None else tuple(arguments.pulls),
        pull_error=_number(arguments.pull_error, "1", "pull-error"),
        position_error=error[0],
    )
    with open_log(arguments.log) as log:
        if log.warning:
            warn(log.warning)
        pictures, count = recorded.pictures(log, asked)
    try:
        found = fit.judge(pictures, Errors(*error, *bias))
    except ValueError as failure:
        raise TowlineError(f"{arguments.log}: {failure}") from failure
    facts = {"frames": count, "frames_used": len(pictures.pose), "points": int((pictures.deviation < 1e300).sum())}
    if arguments.json:
        print_json(facts | _keys(found))
    else:
        _print(facts, found)
    return 0


def _number(text: str, unit: str, option: str, *, negative: bool = False) -> float:
    """A positive number, bare or with its unit. Raises TowlineError."""
    try:
        value = si_value(text.strip(), unit, bare=True)
    except ValueError as error:
        raise TowlineError(f"--{option}: {error}") from error
    if not isfinite(value) or (value <= 0.0 and not negative):
        raise TowlineError(f"--{option}: {text.strip()} is not above 0")
    return value


def _pose(arguments: argparse.Namespace, name: str) -> tuple[float, float]:
    """Deviations in m and rad."""
    given = getattr(arguments, name)
    if given is None:
        return 0.0, 0.0
    option = name.replace("_", "-")
    try:
        metres, degrees = (float(text) for text in given)
    except ValueError as error:
        raise TowlineError(f"--{option}: {' '.join(given)} are no two numbers; expected such as 0.1 1") from error
    if not (0.0 <= metres < float("inf") and 0.0 <= degrees < float("inf")):
        raise TowlineError(f"--{option}: {' '.join(given)}: expected two numbers that are not negative")
    return metres, radians(degrees)


def _keys(found: Judgement) -> dict[str, Any]:
    """The keys of --json about the laws."""
    least = found.fits[0].chi2
    laws = [
        {
            "law": one.family.name,
            "ratio": one.ratio,
            "ratio_low": one.low,
            "ratio_high": one.high,
            "coefficient": one.coefficient,
            "chi2": one.chi2,
            "freedom": one.freedom,
            "above_best": one.chi2 - least,
            "allowed": one.family.name in found.equal,
        }
        for one in found.fits
    ]
    return {"laws": laws, "confounded": len(found.equal) > 1, "scale": found.scale, "fits": found.fits_at_all}


def _ratio(one: Fit) -> str:
    if one.family.ratio is not None:
        return "c_V = c_S"
    if one.high - one.low > 0.999:
        return "any ratio"
    return f"c_V/c_S = {one.ratio:.3f} (95 %: {one.low:.3f} to {one.high:.3f})"


def _print(facts: dict[str, int], found: Judgement) -> None:
    out = console()
    out.print(f"{facts['points']} points in {facts['frames_used']} steady of {facts['frames']} pictures")
    for one in found.fits:
        unit = "N s/m²" if one.family.power == 1 else "N s²/m³"
        pulled = "" if one.coefficient is None else f", c = {one.coefficient:.4g} {unit}"
        is_allowed = one.family.name in found.equal
        verdict = "allowed" if is_allowed else "excluded"
        above = one.chi2 - found.fits[0].chi2
        out.print(f"  {one.family.name}: {_ratio(one)}{pulled}; χ² {one.chi2:.1f} of {one.freedom}, "
                  f"{above:.1f} above the best: {verdict}", soft_wrap=True)  # fmt: skip
    if not found.fits_at_all:
        out.print(f"No law fits within the noise: the best has {found.scale:.2f} times the χ² of its freedom, by which "
                  "the intervals are widened. Check noise, poses' errors, the water's drift, the rope's length, and "
                  "that a simulated rope has segments enough.", soft_wrap=True)  # fmt: skip
    if len(found.equal) > 1:
        out.print(f"Confounded: {' and '.join(found.equal)} fit equally. Steady shapes cannot tell linear drag with "
                  "c_V = c_S, quadratic drag across only and isotropic quadratic drag apart; pulls at two speeds and "
                  "two separations do (--pulls).", soft_wrap=True)  # fmt: skip
