"""Loads of the weather on a vessel, tabulated over wind speed and heading."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from pipeline.errors import TowlineError

SPEED, HEADING = "wind_speed_m_s", "heading_deg"
# Columns of the three loads, in any of these units, and what they are in SI.
FORCES = {"N": 1.0, "kN": 1e3, "MN": 1e6}
MOMENTS = {"Nm": 1.0, "kNm": 1e3, "MNm": 1e6}


@dataclass(frozen=True)
class Loads:
    """speeds: (k,) [m/s] ascending; headings: (h,) [deg] where the weather comes from; table: (h, k, 3) [N, N, N m]."""

    speeds: np.ndarray
    headings: np.ndarray
    table: np.ndarray


def read_loads(path: Path) -> Loads:
    """The table of a CSV file with one row a wind speed and heading.

    Columns: wind_speed_m_s, heading_deg, surge_kN, sway_kN, yaw_kNm (or in N, MN). Raises TowlineError where it is
    not whole.
    """
    try:
        rows = pd.read_csv(path)
    except (OSError, ValueError, UnicodeError) as error:
        text = error.strerror if isinstance(error, OSError) else str(error).splitlines()[0]
        raise TowlineError(f"{path}: cannot be read: {text}") from error
    rows.columns = [str(column).strip() for column in rows.columns]
    found = [_column(path, rows, name, {"": 1.0}) for name in (SPEED, HEADING)]
    found += [
        _column(path, rows, name, units) for name, units in (("surge", FORCES), ("sway", FORCES), ("yaw", MOMENTS))
    ]
    speed, heading = found[:2]
    speeds, headings = np.unique(speed), np.unique(heading)
    table = np.full((len(headings), len(speeds), 3), np.nan)
    table[np.searchsorted(headings, heading), np.searchsorted(speeds, speed)] = np.stack(found[2:], axis=1)
    if len(rows) != len(headings) * len(speeds) or np.isnan(table).any():
        lacking = np.argwhere(np.isnan(table[:, :, 0]))
        where = (
            f"no load at {speeds[lacking[0][1]]:g} m/s from {headings[lacking[0][0]]:g} deg"
            if len(lacking)
            else "twice"
        )
        text = f"{len(rows)} rows for {len(speeds)} wind speeds and {len(headings)} headings: {where}"
        raise TowlineError(f"{path}: {text}; expected one row for each speed and heading")
    return Loads(speeds, headings, table)


def _column(path: Path, rows: pd.DataFrame, name: str, units: dict[str, float]) -> np.ndarray:
    """A column of finite numbers in SI."""
    names = {f"{name}_{unit}" if unit else name: scale for unit, scale in units.items()}
    column = next((one for one in names if one in rows.columns), None)
    if column is None:
        raise TowlineError(f"{path}: no column {' or '.join(names)}; it has {', '.join(map(str, rows.columns))}")
    values = np.asarray(pd.to_numeric(rows[column], errors="coerce"), np.float64)
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        raise TowlineError(f"{path}:{bad[0] + 2}: {column} is '{rows[column].iloc[bad[0]]}'; expected a number")
    return values * names[column]
