"""The page of all benchmarks in Markdown: a section each, which its next run replaces."""

from __future__ import annotations

import os
import platform
import re
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipeline.commands import bench_figure
from pipeline.errors import TowlineError

HEAD = """# Benchmarks

Speed beside its error, error beside its reference. `towline bench NAME --page {page}` measures a section anew,
`make bench` all of them. Machines are shared and noisy: believe ratios within a section, not numbers across sections.
"""
TITLE = HEAD.partition("\n")[0]
ALIKE = 0.6  # of the columns of two rows, those that both fill
_HEADING = re.compile(r"^## (.+)$", re.MULTILINE)


@dataclass(frozen=True)
class Measured:
    """What a benchmark gave. about: its first line. figures: what it drew. load: of the machine, before and after."""

    about: str
    rows: Sequence[Mapping[str, Any]]
    figures: Sequence[Path]
    seconds: float
    load: tuple[float, float]


def load() -> float:
    """Processes that ran or waited in the last minute, in the mean."""
    return os.getloadavg()[0]


def shown(value: Any) -> str:
    """A number with four digits, or a text; nothing for None."""
    return f"{value:.4g}" if isinstance(value, float) else "" if value is None else str(value)


def alike(rows: Sequence[Mapping[str, Any]]) -> list[list[Mapping[str, Any]]]:
    """Rows one after another that fill much the same columns: a table each."""
    groups: list[list[Mapping[str, Any]]] = []
    columns: set[str] = set()
    for row in rows:
        filled = {column for column, value in row.items() if shown(value)}
        if not groups or len(filled & columns) < ALIKE * len(filled | columns):
            groups.append([])
            columns = set()
        groups[-1].append(row)
        columns |= filled
    return groups


def split(rows: Sequence[Mapping[str, Any]]) -> tuple[list[str], dict[str, str]]:
    """The columns in which rows differ, and what the others hold in all of them."""
    columns = list(dict.fromkeys(key for row in rows for key in row if shown(row[key])))
    values = {column: {shown(row.get(column, "")) for row in rows} for column in columns}
    shared = {column: only for column, (only, *others) in values.items() if len(rows) > 1 and not others}
    return [column for column in columns if column not in shared], shared


def update(page: Path, name: str, measured: Measured) -> None:
    """Put a benchmark's section in its place by name.

    Raises TowlineError if the page cannot be read or written, or is another text.
    """
    try:
        before = page.read_text() if page.exists() else ""
        if before and not before.startswith(TITLE):
            raise TowlineError(f"{page} does not begin with '{TITLE}': it is no page of benchmarks; name another")
        sections = _sections(before)
        sections[name] = _section(page, name, measured)
        parts = [HEAD.format(page=page.name), *(f"## {key}\n\n{sections[key]}" for key in sorted(sections))]
        page.write_text("\n".join(part.rstrip() + "\n" for part in parts))
    except OSError as error:
        raise TowlineError(f"{page}: {error.strerror}") from error


def _sections(text: str) -> dict[str, str]:
    _, *parts = _HEADING.split(text)
    return {name: body.strip() for name, body in zip(parts[::2], parts[1::2], strict=True)}


def _figures(page: Path, name: str, measured: Measured) -> Sequence[Path]:
    """Those that the benchmark drew itself; else one of its error against its speed, beside the page."""
    out = page.absolute().parent / f"bench_{name}.svg"
    return measured.figures or ([out] if bench_figure.draw(measured.rows, out) else [])


def _section(page: Path, name: str, measured: Measured) -> str:
    lines = [measured.about]
    for rows in alike(measured.rows):
        differing, shared = split(rows)
        lines += ["", *_table([differing, *([shown(row.get(c, "")) for c in differing] for row in rows)])]
        lines += ["", *(f"- {column}: {value}" for column, value in shared.items())] if shared else []
    folder = page.absolute().parent
    lines += [f"\n![{figure.stem}]({os.path.relpath(figure, folder)})" for figure in _figures(page, name, measured)]
    before, after = measured.load
    told = f"{_machine()}, load {before:.1f} before and {after:.1f} after, {measured.seconds:.0f} s."
    lines += ["", f"{time.strftime('%Y-%m-%d')}, {told}"]
    return "\n".join(lines)


def _table(rows: Sequence[Sequence[str]]) -> list[str]:
    def line(cells: Sequence[str]) -> str:
        return "| " + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in cells) + " |"

    return [line(rows[0]), "|" + "---|" * len(rows[0]), *(line(row) for row in rows[1:])]


def _machine() -> str:
    try:
        names = re.findall(r"^model name\s*: (.+)$", Path("/proc/cpuinfo").read_text(), re.MULTILINE)
    except OSError:
        names = []
    return f"{os.cpu_count()} cores of {names[0] if names else platform.machine()}"
