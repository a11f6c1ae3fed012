"""towline validity: whether a catenary models a recorded line, in tables like those of Drupt et al. 2022."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

from rich.console import Console
from rich.table import Table

from pipeline.analysis import line_tables
from pipeline.analysis.indicators import METHODS
from pipeline.analysis.line_validity import TITLES
from pipeline.analysis.marker_time import UNITS_NS
from pipeline.analysis.reading import Reading
from pipeline.analysis.recording import is_log, recordings
from pipeline.analysis.tables import INDICATORS, failures, noise, rows
from pipeline.analysis.validity import TENSION_TOLERANCE, Cable, Tolerance, judge
from pipeline.analysis.vertical import UPS
from pipeline.commands.output import console, print_json, saying_that_fits_compile, warn
from pipeline.errors import TowlineError
from pipeline.log.reader import open_log
from pipeline.quantities import shown, si_value

# "Less than 1 % of its length, indicating that it can be well approximated by a catenary" (Drupt et al. 2022, IV).
TOLERANCE = "1%"
_SHARE = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?) *%")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    parser.add_argument("log", type=Path, help="a log, a CSV of markers, or an MCAP file of another tool")
    parser.add_argument("--channel", metavar="NAME", help="channel or cable (default: all that have markers)")
    parser.add_argument("--method", choices=METHODS, default=METHODS[0], help=f"of the fits (default: {METHODS[0]})")
    text = "e_C at which the catenary fails: a share of the line's length, or a length (default: %(default)s)"
    parser.add_argument("--tolerance", default=TOLERANCE, metavar="X", help=text)
    text = "error of the end tensions at which the catenary through a line's ends fails (default: %(default)s)"
    parser.add_argument("--tension-tolerance", default=f"{100 * TENSION_TOLERANCE:g}%", metavar="X", help=text)
    parser.add_argument("--length", metavar="M", help="of the line [m] (default: the log's, or along the markers)")
    parser.add_argument("--noise", metavar="X", help="of a marker, along each axis (default: the log's, or found)")
    parser.add_argument("--up", choices=UPS, help="in a file that does not say (default: as the line hangs)")
    parser.add_argument("--time-unit", choices=UNITS_NS, help="of a table's times (default: by header, size and step)")
    parser.add_argument(
        "--field", metavar="A.B", help="of another tool's messages: the list of points (default: the only)"
    )


def cables(arguments: argparse.Namespace, needed: bool = True) -> tuple[list[Cable], list[str]]:
    """The cables that the arguments ask for, judged; and a line on each that cannot be.

    Raises TowlineError if there are none, or none that can be judged, and they are needed.
    """
    tolerance = _tolerance(arguments.tolerance.strip())
    tension = _share(arguments.tension_tolerance)
    length = None if arguments.length is None else _positive("length", arguments.length)
    noise_m = None if arguments.noise is None else _positive("noise", arguments.noise)
    reading = Reading(arguments.channel, arguments.field, arguments.up, arguments.time_unit)
    if is_log(arguments.log):
        with open_log(arguments.log) as log:
            if log.warning:
                warn(log.warning)
    read = recordings(arguments.log, reading, needed)
    if not read:
        return [], []
    found, unjudged = [], []
    with saying_that_fits_compile(arguments.method, arguments.json):
        for recording in read:
            try:
                found.append(judge(recording.with_noise(noise_m), arguments.method, tolerance, length, tension))
            except TowlineError as error:
                unjudged.append(str(error))
    if needed and not found:
        raise TowlineError("\n".join(unjudged))
    unjudged = [f"not judged: {text}" for text in unjudged]
    notes = [f"{one.recording.frames.source}: {note}" for one in found for note in one.recording.frames.notes]
    for text in (*unjudged, *notes):
        warn(text)
    return found, unjudged


def seconds(texts: list[str]) -> tuple[float, ...]:
    """Times of a window [s]. Raises TowlineError if they are none, or not in order."""
    try:
        times = tuple(si_value(text.strip(), "s", bare=True) for text in texts)
    except ValueError as error:
        raise TowlineError(f"--window: {error}") from error
    if not all(a < b for a, b in pairwise(times)):
        raise TowlineError(f"--window: {' '.join(texts)}: the end must be later than the start")
    return times


def _tolerance(text: str) -> Tolerance:
    try:
        share = _SHARE.fullmatch(text)
        value = float(share[1]) / 100.0 if share else si_value(text, "m", bare=True)
    except ValueError as error:
        raise TowlineError(
            f"--tolerance: {shown(text)} is no share of the length and no length; expected such as '1%' or '10 mm'"
        ) from error
    if not 0.0 < value < (1.0 if share else float("inf")):
        raise TowlineError(
            f"--tolerance: {text} is not {'between 0 and 100 %' if share else 'positive'}; "
            "expected such as '1%' or '10 mm'"
        )
    return Tolerance(value, share is not None)


def _share(text: str) -> float:
    text = text.strip()
    share = _SHARE.fullmatch(text)
    if share is None or not 0.0 < float(share[1]) < 1e6:
        raise TowlineError(f"--tension-tolerance: {shown(text)} is no share of a tension; expected such as '10%'")
    return float(share[1]) / 100.0


def _positive(name: str, text: str, unit: str = "m") -> float:
    try:
        value = si_value(text.strip(), unit, bare=True)
    except ValueError as error:
        raise TowlineError(f"--{name}: {error}") from error
    if not 0 < value < float("inf"):
        raise TowlineError(f"--{name}: {text.strip()} is not positive")
    return value


def command(arguments: argparse.Namespace) -> int:
    """Judge and print."""
    found, _ = cables(arguments)
    if arguments.json:
        print_json({"cables": {cable.recording.name: cable.as_json() for cable in found}})
        return 0
    for cable in found:
        print_cable(console(), cable)
    return 0


def print_cable(out: Console, cable: Cable) -> None:
    """A cable's tables and what to know of them."""
    table = Table(title=f"{cable.recording.name}: {cable.recording.origin.scenario or cable.recording.frames.source}")
    table.add_column("")
    for title in INDICATORS.values():
        table.add_column(title, justify="right")
        if cable.published:
            table.add_column("published", justify="right", style="dim")
    for name, values in rows(cable):
        table.add_row(name, *values)
    out.print(table)
    for text in _sentences(cable):
        out.print(text, soft_wrap=not out.is_terminal)  # a file's lines are left whole
    _print_spans(out, cable)
    if cable.line is not None:
        _print_line(out, cable)


def _sentences(cable: Cable) -> Iterator[str]:
    """What stands below the table, a paragraph each."""
    yield str(cable.durations)
    yield f"{failures(cable)} {noise(cable)}"
    yield f"fitted in {cable.wall_s:.3g} s"
    for reason, count in cable.fits.reasons().items():
        yield f"  {count} {reason}"
    for note in cable.fits.notes:
        yield f"  {note}"
    if cable.published:
        yield f"published: {cable.published.table} of {cable.published.source}"


def _print_spans(out: Console, cable: Cable, most: int = 10) -> None:
    """The spans of failure, the worst ones if they are many."""
    if not cable.spans:
        return
    chosen = sorted(sorted(cable.spans, key=lambda span: -span.worst)[:most], key=lambda span: span.start_ns)
    table = Table(title="" if len(chosen) == len(cable.spans) else f"the {most} worst of {len(cable.spans)} spans")
    for column in ("from [s]", "to [s]", "frames", "largest e_C [mm]"):
        table.add_column(column, justify="right")
    if cable.line is not None:
        table.add_column("cause")
    for span in chosen:
        times = (f"{t_ns / 1e9:.2f}" for t_ns in (span.start_ns, span.end_ns))
        why = [] if cable.line is None else [line_tables.cause(cable.cause(span)[0], cable.line, of_fit=True)]
        table.add_row(*times, str(span.frames), f"{1e3 * span.worst:.4g}", *why)
    out.print(table)


def _print_line(out: Console, cable: Cable, most: int = 10) -> None:
    """The catenary through the line's ends, and what loads the line where it fails."""
    assert cable.line is not None
    for text in line_tables.sentences(cable.line):
        out.print(text, soft_wrap=not out.is_terminal)
    for name, match in cable.line.matches.items():
        if not match.failures:
            continue
        chosen = line_tables.worst(match, most)
        which = "" if len(chosen) == len(match.failures) else f", the {most} longest of {len(match.failures)} spans"
        table = Table(title=f"{TITLES[name]}{which}")
        for column in line_tables.COLUMNS:
            table.add_column(column, justify="left" if column == "cause" else "right")
        for failure in chosen:
            table.add_row(*line_tables.row(failure, cable.line))
        out.print(table)
