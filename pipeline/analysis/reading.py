"""What the user says of a file that does not say it itself."""

from __future__ import annotations

from dataclasses import dataclass

from pipeline.analysis.vertical import Up


@dataclass(frozen=True)
class Reading:
    """channel: the cable to take, None for all. field: of an MCAP message, the list of points, such as `rigid.markers`.

    up, time_unit: of positions and of a table's times; None to find out.
    """

    channel: str | None = None
    field: str | None = None
    up: Up | None = None
    time_unit: str | None = None
