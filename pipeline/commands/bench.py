"""towline bench: run the benchmarks of tests/benchmarks; speed beside its error, error beside its reference."""

from __future__ import annotations

import argparse
import importlib.util
import sys
from pathlib import Path
from typing import Any

from rich.table import Table

import components
from pipeline.commands.output import console, print_json
from pipeline.errors import TowlineError

FOLDER = Path(components.__file__).parent.parent / "tests" / "benchmarks"
ABSENT = "this installation has no benchmarks: they are in the repository only"
ON_REQUEST = ("soak",)  # takes half an hour, and so is not among `all`
Row = dict[str, Any]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    names = ", ".join(_found())
    text = f"which one, or all ({names})" if names else ABSENT
    parser.add_argument("name", help=text)


def _found() -> dict[str, Path]:
    """The benchmarks' files by name."""
    return {path.stem: path for path in sorted(FOLDER.glob("*.py"))}


def _rows(path: Path) -> list[Row]:
    spec = importlib.util.spec_from_file_location(f"benchmark_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up by name
    if str(path.parent) not in sys.path:
        sys.path.append(str(path.parent))  # a benchmark may import what lies beside it
    spec.loader.exec_module(module)
    return module.rows()


def _shown(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _print(name: str, rows: list[Row]) -> None:
    """What differs between rows as a table, what they share below it."""
    columns = list(dict.fromkeys(key for row in rows for key in row))
    shared = {column for column in columns if len(rows) > 1 and len({_shown(row.get(column, "")) for row in rows}) == 1}
    shown = [column for column in columns if column not in shared]
    table = Table(title=name)
    for column in shown:
        table.add_column(column)
    for row in rows:
        table.add_row(*(_shown(row.get(column, "")) for column in shown))
    console().print(table)
    for column in columns:
        if column in shared:
            console().print(f"{column}: {_shown(rows[0][column])}")


def command(arguments: argparse.Namespace) -> int:
    """Run it. Raises TowlineError if there is no such benchmark."""
    found = _found()
    if not found:
        raise TowlineError(ABSENT)
    every = [name for name in found if name not in ON_REQUEST]
    wanted = every if arguments.name == "all" else [arguments.name]
    unknown = [name for name in wanted if name not in found]
    if unknown:
        raise TowlineError(f"no benchmark {arguments.name}; there are {', '.join(found)}")
    results = {}
    for name in wanted:
        console().print(f"measuring {name} ...")
        results[name] = _rows(found[name])
        if not arguments.json:
            _print(name, results[name])
    if arguments.json:
        print_json({"rows": [{"benchmark": name, **row} for name, rows in results.items() for row in rows]})
    return 0
