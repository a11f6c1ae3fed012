"""Times of a table as integer nanoseconds: in a stated unit, ISO 8601, of day, or the unit that size and step show."""

from __future__ import annotations

import re

import numpy as np

from pipeline.analysis.marker_text import Table
from pipeline.errors import LogError
from pipeline.quantities import LATEST, shown

UNITS_NS = {"s": 10**9, "ms": 10**6, "us": 10**3, "ns": 1}
EPOCH_S = (631_152_000, 4_102_444_800)  # 1990 to 2100 since 1970: no record's own clock runs that long
_OF_DAY = re.compile(r"(\d{1,2}):([0-5]\d):([0-5]\d)(?:[.,](\d{1,9}))?")
DAY_NS = 86_400 * 10**9
SLOWEST = 2.0  # s from frame to frame; what would be slower than this in seconds is in a smaller unit


def times_of(table: Table, column: int, unit: str | None, given: str | None) -> tuple[np.ndarray, np.ndarray, str]:
    """Times (k,) int64 [ns], which rows have one, (n,) bool, and a note or "".

    unit: by the column's name; given: by the user, which counts before it. Raises LogError with the place.
    """
    cells, known = table.cells[column], ~table.empty(column)
    if cells.dtype == object and _are_dates(cells[known]):
        return _dates(table, column, known), known, f"column '{table.names[column]}' read as ISO 8601 times (UTC)"
    if cells.dtype == object and known.any() and ":" in str(cells[known][0]):
        return _times_of_day(table, column, known), known, f"column '{table.names[column]}' read as times of day"
    numbers = cells if cells.dtype.kind == "i" else table.numbers(column)
    known = known & np.isfinite(numbers.astype(np.float64))
    values = numbers[known]
    note = ""
    taken = given or unit
    if taken is None:
        taken, why = _likely(values)
        note = f"column '{table.names[column]}' has no unit: taken as {taken}, {why}; else give --time-unit"
    factor = UNITS_NS[taken]
    if len(values) and float(np.abs(values.astype(np.float64)).max()) * factor >= LATEST:
        row = int(np.flatnonzero(known)[np.abs(values.astype(np.float64)).argmax()])
        raise LogError(f"{table.place(row, column)}: beyond 292 years in {taken}; give the unit with --time-unit")
    t_ns = values.astype(np.int64) * factor if values.dtype.kind == "i" else np.rint(values * factor).astype(np.int64)
    return t_ns, known, note


def _are_dates(cells: np.ndarray) -> bool:
    return bool(len(cells)) and isinstance(cells[0], str) and str(cells[0]).strip()[4:5] == "-"


def _times_of_day(table: Table, column: int, known: np.ndarray) -> np.ndarray:
    """(n,) int64 [ns] since the first midnight: where half a day or more is gone back, another one has passed."""
    found = []
    for row in np.flatnonzero(known):
        text = str(table.cells[column][row]).strip()
        parts = _OF_DAY.fullmatch(text)
        if parts is None or int(parts[1]) > 23:
            raise LogError(
                f"{table.place(int(row), column)}: {shown(text)} is not a time of day such as 12:00:00.020; "
                "expected that, seconds, or times such as 2024-01-31T12:00:00.020Z"
            )
        whole = 3600 * int(parts[1]) + 60 * int(parts[2]) + int(parts[3])
        found.append(whole * 10**9 + int((parts[4] or "").ljust(9, "0")))
    t_ns = np.array(found, np.int64)
    return t_ns + DAY_NS * np.concatenate([[0], np.cumsum(np.diff(t_ns) < -DAY_NS // 2)])


def _dates(table: Table, column: int, known: np.ndarray) -> np.ndarray:
    import pandas

    texts = pandas.Series(table.cells[column][known]).astype(str).str.strip()
    try:
        found = pandas.to_datetime(texts, utc=True, format="ISO8601", errors="coerce")
        whole = found.dt.tz_localize(None).dt.as_unit("ns")
    except (ValueError, OverflowError) as error:
        raise LogError(f"{table.path}: column '{table.names[column]}': {str(error).splitlines()[0]}") from error
    if found.isna().any():
        row = int(np.flatnonzero(known)[int(found.isna().to_numpy().argmax())])
        text = shown(str(table.cells[column][row]))
        raise LogError(f"{table.place(row, column)}: {text} is not a time such as 2024-01-31T12:00:00.020Z")
    return whole.to_numpy().astype(np.int64)


def _likely(values: np.ndarray) -> tuple[str, str]:
    """The unit of numbers that do not say, and why."""
    numbers = np.sort(values.astype(np.float64))
    middle = float(np.median(numbers)) if len(numbers) else 0.0
    for unit, factor in UNITS_NS.items():
        per_second = UNITS_NS["s"] / factor
        if EPOCH_S[0] * per_second <= middle <= EPOCH_S[1] * per_second:
            return unit, "which makes them times since 1970"
    steps = np.diff(numbers)
    step = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    for unit, factor in UNITS_NS.items():
        if step * factor <= SLOWEST * UNITS_NS["s"]:
            return unit, f"the step is then {step * factor / 1e9:.3g} s"
    return "ns", "the smallest unit"
