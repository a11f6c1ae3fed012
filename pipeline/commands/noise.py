"""towline noise: the noises of an estimator of a line, Q and R, that make a log's measurements most likely."""

from __future__ import annotations

import argparse
from math import exp, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline.commands.output import console, print_json, warn
from pipeline.errors import LogError, TowlineError
from pipeline.log.reader import Log, open_log
from pipeline.quantities import si_value

if TYPE_CHECKING:
    from pipeline.estimation.fitting import Fit
    from pipeline.estimation.record import Record, Walk

SIGMAS = 1.96  # of a 95 % interval
UNTOLD = "not told by this log"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    parser.add_argument("log", type=Path, help="of a run with estimator.best or estimator.corrected")
    parser.add_argument("--component", metavar="NAME", help="the estimator (default: the only one)")
    text = "parameters to fit (default: all noises that have an effect; time constants only if named)"
    parser.add_argument("--fit", nargs="+", metavar="NAME", help=text)
    parser.add_argument("--window", nargs=2, metavar=("FROM", "TO"), help="times to look at [s]")


def command(arguments: argparse.Namespace) -> int:
    """Read, fit and print."""
    from pipeline.estimation.fitting import fit_noises  # scipy and numba take a while to import

    with open_log(arguments.log) as log:
        if log.warning:
            warn(log.warning)
        name, record = _record(log, arguments.component)
    if arguments.window:
        first, last = (_seconds(text) for text in arguments.window)
        try:
            record = record.between(first, last)
        except ValueError as error:
            raise TowlineError(f"--window: {error}") from error
    names = _names(record, arguments.fit)
    try:
        before = record.walk()
        if before.seen == 0:
            raise LogError(f"{arguments.log}: {name} saw no marker, which leaves nothing to fit to")
        found = fit_noises(record, names)
        after = record.with_parameters(**found.noises).walk()
    except ValueError as error:
        raise LogError(f"{arguments.log}: {name}: {error}") from error
    if arguments.json:
        print_json(_keys(name, record, found, before, after))
    else:
        _print(name, record, found, before, after)
    return 0


def _record(log: Log, name: str | None) -> tuple[str, Record]:
    """The estimator asked for, or the only one. Raises LogError."""
    from pipeline.estimation.record import estimators_in, record_of

    if name is None:
        names = estimators_in(log)
        if not names:
            raise LogError(f"{log.path}: no estimator.best or estimator.corrected, whose noises could be fitted")
        if len(names) > 1:
            raise LogError(f"{log.path}: {len(names)} estimators; choose one by --component {' or '.join(names)}")
        name = names[0]
    return name, record_of(log, name)


def _names(record: Record, asked: list[str] | None) -> tuple[str, ...]:
    """What is fitted. Raises TowlineError."""
    from pipeline.estimation.fitting import TIMES, noises_of

    there = noises_of(record)
    for name in asked or ():
        if name not in there:
            raise TowlineError(f"--fit: {name} is no noise that has an effect here; expected of {', '.join(there)}")
    return tuple(dict.fromkeys(asked or (name for name in there if name not in TIMES)))


def _seconds(text: str) -> float:
    try:
        return si_value(text.strip(), "s", bare=True)
    except ValueError as error:
        raise TowlineError(f"--window: {error}") from error


def _unit(record: Record, name: str) -> str:
    from pipeline.parameters import unit_of

    return unit_of(type(record.parameters), name) or "1"


def _interval(found: Fit, name: str) -> tuple[float, float]:
    factor = exp(SIGMAS * found.deviations[name]) if isfinite(found.deviations[name]) else float("inf")
    return found.noises[name] / factor, found.noises[name] * factor


def _keys(name: str, record: Record, found: Fit, before: Walk, after: Walk) -> dict[str, Any]:
    """The keys of --json."""
    rows = {}
    for key, value in found.noises.items():
        low, high = _interval(found, key)
        rows[key] = {
            "unit": _unit(record, key),
            "before": getattr(record.parameters, key),
            "fitted": value,
            "low": low if isfinite(high) else None,
            "high": high,
        }
    told = {key: {"before": getattr(before, key), "fitted": getattr(after, key)} for key in ("nis", "seen", "refused")}
    told["log_likelihood"] = {"before": found.before, "fitted": found.log_likelihood}
    return {"component": name, "frames": len(record.t_ns), "parameters": rows, "evaluations": found.evaluations} | told


def _print(name: str, record: Record, found: Fit, before: Walk, after: Walk) -> None:
    from rich.table import Table

    out, table = console(), Table()
    for heading in ("parameter", "unit", "in the log", "fitted", "95 % interval"):
        table.add_column(heading, justify="left" if heading in ("parameter", "unit") else "right")
    for key, value in found.noises.items():
        low, high = _interval(found, key)
        span = f"{low:.3g} to {high:.3g}" if isfinite(high) else UNTOLD
        table.add_row(key, _unit(record, key), f"{getattr(record.parameters, key):.4g}", f"{value:.4g}", span)
    out.print(table)
    gain = found.log_likelihood - found.before
    out.print(
        f"{name}, {len(record.t_ns)} frames: log-likelihood {found.log_likelihood:.1f}, {gain:+.1f} by the fit; "
        f"NIS per innovation {before.nis:.3g}, fitted {after.nis:.3g}; "
        f"refused {before.refused}, fitted {after.refused}, of {after.seen} readings"
    )
    if after.refused > before.refused:
        gate = record.parameters.gate
        out.print(
            f"With these, {after.refused - before.refused} more readings are beyond the gate of {gate:g} deviations: "
            "they are not as normal as a filter takes them. Widen the gate, or keep larger noises."
        )
    out.print(f"For the parameters of {name}:")
    for key, value in found.noises.items():
        told = "" if isfinite(found.deviations[key]) else f"  # {UNTOLD}"
        out.print(f"      {key}: {value:.3g} {_unit(record, key)}{told}")
