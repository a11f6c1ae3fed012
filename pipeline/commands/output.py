"""What commands share in talking to a person: the console, the progress bar, and JSON."""

from __future__ import annotations

import dataclasses
import json
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import isfinite
from typing import TYPE_CHECKING, Any, NoReturn

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

from components import cache
from pipeline.compilation import compile_side_by_side
from pipeline.errors import TowlineError

if TYPE_CHECKING:
    from pipeline.graph import Graph

FILE_WIDTH = 160  # columns where nobody's terminal sets them: no cell of a table is cut
BUS_CONFIG_HELP = "zenoh configuration (JSON5 or YAML): TLS, user and password, access control"
NOTICE_S = 0.1  # a bar is drawn at most this often


def console() -> Console:
    """Where people read: standard error, so that standard output stays for results."""
    out = Console(stderr=True, highlight=False, markup=False, soft_wrap=True)
    if not out.is_terminal:
        out.width = FILE_WIDTH
    return out


def print_json(value: Any) -> None:
    """One JSON object on standard output, written out; dataclasses become objects, non-finite numbers null.

    Raises TowlineError if it cannot be written, BrokenPipeError if nobody reads it.
    """
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        value = dataclasses.asdict(value)
    try:
        print(json.dumps(_without_infinities(value), allow_nan=False), flush=True)
    except BrokenPipeError:
        raise
    except OSError as error:
        raise TowlineError(f"cannot write to standard output: {error.strerror}") from error


def _without_infinities(value: Any) -> Any:
    """JSON has no NaN and no infinity."""
    if isinstance(value, dict):
        return {key: _without_infinities(member) for key, member in value.items()}
    if isinstance(value, list | tuple):
        return [_without_infinities(member) for member in value]
    return None if isinstance(value, float) and not isfinite(value) else value


def compile_fresh(graph: Graph, quiet: bool) -> None:
    """Name the components that are in no cache yet, and compile them side by side.

    Raises PackageNotFoundError where the run would end at once, after minutes of compiling.
    """
    from components import compiled  # with numba, which not every command needs
    from pipeline.provenance import versions

    versions()
    fresh = sorted({n.component.name for n in graph.nodes if not compiled.is_cached(n.component)})
    fresh += [] if cache.is_marked("native_loop") else ["the loop"]
    if fresh and not quiet:
        _say_compiling(", ".join(fresh))
    compile_side_by_side(fresh)


@contextmanager
def saying_that_fits_compile(method: str, quiet: bool) -> Iterator[None]:
    """Say that the kernels of a method of fitting are about to be compiled, and note afterwards that they were."""
    name = f"analysis-{method}"
    if not cache.is_marked(name) and not quiet:
        _say_compiling(f"the fits of the method {method}")
    yield
    cache.mark_cached(name)


def _say_compiling(what: str) -> None:
    console().print(f"compiling {what} (once; kept in {cache.cache_folder()})")


def leave(text: str, as_json: bool) -> NoReturn:
    """End the process with an error, from another thread than the main one."""
    from pipeline.cli import report

    report(text, as_json)
    os._exit(1)


def warn(text: str) -> None:
    """A warning on standard error, also under --json."""
    print(f"towline: warning: {text}", file=sys.stderr)


@contextmanager
def progress_bar(
    title: str, end_s: float, start_s: float = 0.0, quiet: bool = False
) -> Iterator[Callable[[float], None]]:
    """A bar with simulated time and real-time factor; yields the function that takes simulated seconds."""
    if quiet or not console().is_terminal:
        yield lambda _: None
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=30),
        TaskProgressColumn(),
        TextColumn("{task.completed:.1f} / {task.total:.1f} s"),
        TextColumn("{task.fields[factor]}"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console(), transient=True) as bar:
        task = bar.add_task(title, total=end_s, factor="")
        began = drawn = 0.0

        def update(simulated_s: float) -> None:
            nonlocal began, drawn
            now = time.monotonic()
            began = began or now
            if now - drawn >= NOTICE_S:
                drawn = now
                factor = f"{(simulated_s - start_s) / (now - began):.4g} x real time" if now > began else ""
                bar.update(task, completed=simulated_s, factor=factor)

        yield update
