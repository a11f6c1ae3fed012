"""The text of a table as columns: its encoding, its separator, its decimal sign, and the line of every cell."""

from __future__ import annotations

import csv
import io
import re
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.errors import LogError
from pipeline.quantities import shown

SEPARATORS = ";\t,|"
_MARKS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16", b"\xef\xbb\xbf": "utf-8-sig"}
_COMMA = re.compile(r"(?<![\w.])[+-]?\d+,\d+")
_POINT = re.compile(r"\d\.\d")
LOOKED_AT = 200  # lines that tell whether the decimal sign is a comma


@dataclass(frozen=True)
class Table:
    """path: for messages. names: of the columns. cells: by column, numbers or texts. lines: (k,) of the rows, from 1.

    notes: what was left out.
    """

    path: Path
    names: list[str]
    cells: list[np.ndarray]
    lines: np.ndarray
    notes: tuple[str, ...] = ()

    def place(self, row: int, column: int) -> str:
        """Where a cell stands, for messages: `markers.csv:17: column 'x1'`."""
        return f"{self.path}:{self.lines[row]}: column '{self.names[column]}'"

    def numbers(self, column: int) -> np.ndarray:
        """A column as float64, NaN where empty. Raises LogError with the place of the first text."""
        cells = self.cells[column]
        if cells.dtype != object:
            return cells.astype(np.float64)
        import pandas

        found = np.asarray(pandas.to_numeric(pandas.Series(cells), errors="coerce"), np.float64)
        wrong = np.flatnonzero(np.isnan(found) & ~self.empty(column))
        if len(wrong):
            text = str(cells[wrong[0]])
            raise LogError(f"{self.place(int(wrong[0]), column)}: {shown(text)} is not a number; {_remedy(text)}")
        return found

    def empty(self, column: int) -> np.ndarray:
        """(k,) bool: cells with nothing in them, or a word for nothing."""
        import pandas

        return np.asarray(pandas.isna(self.cells[column]))

    def rows(self, keep: np.ndarray) -> Table:
        """Some of the rows."""
        return Table(self.path, self.names, [c[keep] for c in self.cells], self.lines[keep], self.notes)


def _remedy(text: str) -> str:
    if re.fullmatch(r"[+-]?\d*,\d+", text.strip()):
        return "decimal commas are read where ';' or a tab stands between the columns, and in all numbers"
    return "leave the cell empty where nothing was seen"


def read_table(path: Path) -> Table:
    """The table in a file. Raises LogError with the place of what cannot be read."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise LogError(f"{path}: cannot read the file: {error.strerror or error}") from error
    text = _decoded(data, path)
    lines = re.split(r"\r\n|\n|\r", text)
    first = next((i for i, line in enumerate(lines) if line.strip() and not line.startswith("#")), None)
    if first is None:
        raise LogError(f"{path}: the file is empty; expected a line with the names of the columns")
    while lines and not lines[-1].strip():
        lines.pop()
    separator = max(SEPARATORS, key=lines[first].count)
    names = _names(lines[first], separator, path, first + 1)
    _check_names(names, path, first + 1)
    if len(lines) == first + 1:
        raise LogError(f"{path}:{first + 1}: there are names of columns, but no rows below them")
    body, notes = _even(lines, first, separator, len(names), path)
    comma = separator != "," and _has_decimal_commas(body)
    cells = _parsed(body, separator, len(names), "," if comma else ".", path, first)
    filled = np.array([bool(line.strip(separator + " ")) for line in body])[: len(cells[0])]
    notes += ("the numbers have decimal commas",) if comma else ()
    return Table(path, names, cells, np.arange(first + 2, first + 2 + len(cells[0])), notes).rows(filled)


def _decoded(data: bytes, path: Path) -> str:
    encoding = next((name for mark, name in _MARKS.items() if data.startswith(mark)), "utf-8")
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError:
        if encoding != "utf-8":
            raise LogError(f"{path}: not {encoding} as its first bytes say; save it as UTF-8") from None
        text = data.decode("latin-1")
    if "\0" in text:
        raise LogError(f"{path}: not a table of text: there are null bytes in it; save it as CSV in UTF-8")
    return text


def _names(line: str, separator: str, path: Path, number: int) -> list[str]:
    try:
        return [name.strip() for name in next(csv.reader([line], delimiter=separator))]
    except csv.Error as error:
        raise LogError(f"{path}:{number}: not a line with the names of columns: {error}") from error


def _check_names(names: list[str], path: Path, line: int) -> None:
    given = [name for name in names if name]
    if given and all(re.fullmatch(r"[+-]?[\d.,eE+-]+", name) for name in given):
        raise LogError(f"{path}:{line}: numbers where the names of the columns are expected: time, x1, y1, z1, ...")
    twice = next((name for name in given if given.count(name) > 1), None)
    if twice is not None:
        raise LogError(f"{path}:{line}: {given.count(twice)} columns are called {shown(twice)}; rename or remove one")


def _even(lines: list[str], first: int, separator: str, columns: int, path: Path) -> tuple[list[str], tuple[str, ...]]:
    """The rows, each with as many cells as there are names; a last one that was cut off is left out and noted."""
    body = lines[first + 1 :]
    if any('"' in line for line in body):
        return body, ()  # a separator may stand in quotes; pandas counts
    for i, line in enumerate(body):
        count = line.count(separator) + 1
        if count == columns or not line.strip(separator + " "):
            continue
        if count < columns and i == len(body) - 1 and i > 0:
            return body[:-1], (f"the last line, {first + 2 + i}, was cut off: left out",)
        if count > columns and not "".join(line.split(separator)[columns:]).strip():
            continue  # separators at the end
        commas = separator == "," and count > columns
        raise LogError(
            f"{path}:{first + 2 + i}: {count} cells, but {columns} columns have names"
            + ("; with decimal commas, put ';' between the columns" if commas else "")
        )
    return body, ()


def _has_decimal_commas(body: list[str]) -> bool:
    some = "\n".join(body[:LOOKED_AT])
    return bool(_COMMA.search(some)) and not _POINT.search(some)


def _parsed(body: list[str], separator: str, columns: int, decimal: str, path: Path, first: int) -> list[np.ndarray]:
    import pandas  # takes half a second to import

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of separators at the end of lines, which _even has looked at
            table = pandas.read_csv(
                io.StringIO("\n".join(body) + "\n"),
                sep=separator,
                header=None,
                names=list(range(columns)),
                index_col=False,
                decimal=decimal,
                skipinitialspace=True,
                skip_blank_lines=False,
                low_memory=False,
            )
    except (ValueError, OverflowError) as error:
        place = re.search(r"line (\d+)", str(error))
        where = f"{path}:{first + 1 + int(place[1])}" if place else str(path)
        raise LogError(f"{where}: not a table: {str(error).splitlines()[0]}") from error
    cells = [table[i].to_numpy() for i in range(columns)]
    return [c if c.dtype.kind in "if" else c.astype(object) for c in cells]
