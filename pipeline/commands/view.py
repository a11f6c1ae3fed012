"""towline view: a log in Rerun, with its layout ready; or a picture of that, or the recording alone."""

from __future__ import annotations

import argparse
import os
import tempfile
from pathlib import Path

from pipeline.commands.output import console, print_json, warn
from pipeline.errors import LogError, TowlineError
from pipeline.log.reader import Log, open_log


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    parser.add_argument("log", type=Path, help="of a run")
    parser.add_argument("--screenshot", type=Path, metavar="F.png", help="save a picture instead of opening a window")
    parser.add_argument("--at", type=float, metavar="T", help="simulated time of the picture [s] (default: the end)")
    parser.add_argument("--save", type=Path, metavar="F.rrd", help="write the recording for Rerun, and open nothing")
    parser.add_argument("--overwrite", action="store_true", help="replace the file if it exists")


def command(arguments: argparse.Namespace) -> int:
    """Write the recording, and show it."""
    from pipeline.viewing.rerun_file import rerun_module
    from pipeline.viewing.viewer import screenshot, show

    rerun_module()
    for out in filter(None, (arguments.screenshot, arguments.save)):
        _check(out, arguments.log, arguments.overwrite)
    if arguments.at is not None and not arguments.screenshot:
        raise TowlineError("--at is the time of a picture; give --screenshot F.png too")
    with tempfile.TemporaryDirectory(prefix="towline-view-") as folder, open_log(arguments.log) as log:
        if not log.channels:
            raise LogError(log.warning or f"{log.path} has no channels: there is nothing to show")
        if log.warning:
            warn(log.warning)
        path = arguments.save or Path(folder) / "recording.rrd"
        end_s = _save(log, arguments.log.stem, path)
        if arguments.screenshot:
            at_s = end_s if arguments.at is None else arguments.at
            if not 0.0 <= at_s <= end_s:
                raise TowlineError(f"--at {at_s:g}: the log ends at {end_s:g} s")
            screenshot(path, arguments.screenshot, at_s)
        elif not arguments.save:
            show(path)
    written = [str(out) for out in (arguments.screenshot, arguments.save) if out]
    if arguments.json:
        print_json({"written": written})
    elif written:
        console().print(*written)
    return 0


def _save(log: Log, title: str, path: Path) -> float:
    """Write the recording whole or not at all; gives the time of its end [s]."""
    from pipeline.viewing.rerun_file import write_recording

    fresh = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        end_s = write_recording(log, title, fresh)
        fresh.replace(path)
    except OSError as error:
        raise TowlineError(f"{path}: cannot be written: {error.strerror}") from error
    finally:
        fresh.unlink(missing_ok=True)
    return end_s


def _check(out: Path, log: Path, overwrite: bool) -> None:
    if out.exists() and log.exists() and out.samefile(log):
        raise TowlineError(f"{out} is the log itself; choose another name")
    if out.exists() and not overwrite:
        raise TowlineError(f"{out} exists already; choose another name, or give --overwrite")
    if not out.absolute().parent.is_dir():
        raise TowlineError(f"{out}: there is no folder {out.absolute().parent}")
