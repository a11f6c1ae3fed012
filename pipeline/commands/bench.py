"""towline bench: run the benchmarks of tests/benchmarks; speed beside its error, error beside its reference."""

from __future__ import annotations

import argparse
import importlib.util
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.table import Table

import components
from pipeline.commands.bench_page import Measured, alike, load, shown, split, update
from pipeline.commands.output import console, print_json
from pipeline.errors import TowlineError

FOLDER = Path(components.__file__).parent.parent / "tests" / "benchmarks"
ABSENT = "this installation has no benchmarks: they are in the repository only"
ON_REQUEST = ("soak",)  # takes half an hour, and so is not among `all`
Row = Mapping[str, Any]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    names = ", ".join(_found())
    text = f"which one, or all ({names})" if names else ABSENT
    parser.add_argument("name", help=text)
    parser.add_argument("--page", type=Path, metavar="F.md", help="a page in Markdown, whose section of it is replaced")


def _found() -> dict[str, Path]:
    """The benchmarks' files by name."""
    return {path.stem: path for path in sorted(FOLDER.glob("*.py"))}


def _measure(path: Path) -> Measured:
    """Run the benchmark of a file."""
    spec = importlib.util.spec_from_file_location(f"benchmark_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up by name
    if str(path.parent) not in sys.path:
        sys.path.append(str(path.parent))  # a benchmark may import what lies beside it
    spec.loader.exec_module(module)
    before, began = load(), time.monotonic()
    rows = module.rows()
    drawn = [getattr(module, name) for name in ("FIGURE",) if hasattr(module, name)]
    about = (module.__doc__ or "").strip().splitlines()[0]
    return Measured(about, rows, drawn, time.monotonic() - began, (before, load()))


def _print(name: str, rows: Sequence[Row]) -> None:
    """What differs between rows as tables, what they share below each."""
    for group in alike(rows):
        differing, shared = split(group)
        table = Table(title=name)
        for column in differing:
            table.add_column(column)
        for row in group:
            table.add_row(*(shown(row.get(column, "")) for column in differing))
        console().print(table)
        for column, value in shared.items():
            console().print(f"{column}: {value}")


def command(arguments: argparse.Namespace) -> int:
    """Run it. Raises TowlineError if there is no such benchmark, or if it fails; of all, the others are run first."""
    found = _found()
    if not found:
        raise TowlineError(ABSENT)
    every = [name for name in found if name not in ON_REQUEST]
    wanted = every if arguments.name == "all" else [arguments.name]
    unknown = [name for name in wanted if name not in found]
    if unknown:
        raise TowlineError(f"no benchmark {arguments.name}; there are {', '.join(found)}")
    results: dict[str, Sequence[Row]] = {}
    failures: list[str] = []
    for name in wanted:
        console().print(f"measuring {name} ...")
        try:
            measured = _measure(found[name])
        except TowlineError as error:
            failures.append(f"{name}: {error}")
            continue
        results[name] = measured.rows
        if arguments.page:
            update(arguments.page, name, measured)
        if not arguments.json:
            _print(name, measured.rows)
    if failures:
        raise TowlineError("\n".join(failures))
    if arguments.json:
        print_json({"rows": [{"benchmark": name, **row} for name, rows in results.items() for row in rows]})
    return 0
