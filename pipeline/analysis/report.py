"""The report of a recording: for each cable its tables, its figures, and what to know before trusting them."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.analysis.ends import Ends
from pipeline.analysis.figures import Window, circumstances, indicators
from pipeline.analysis.statistics import LEAST_MARKERS, reliable
from pipeline.analysis.validity import Cable
from pipeline.errors import TowlineError

CLOSE_S = 15.0  # length of the close-up: figures 4 to 7 of Drupt et al. 2022 show 15 s


@dataclass(frozen=True)
class Picture:
    """A figure with its caption: svg is an element to stand in a page."""

    svg: str
    caption: str


@dataclass(frozen=True)
class Spread:
    """The pictures of one stretch of time."""

    title: str
    pictures: list[Picture]


@dataclass(frozen=True)
class Section:
    """What the report says of one cable."""

    cable: Cable
    spreads: list[Spread]


def sections(cables: list[Cable], window: Window | None = None) -> list[Section]:
    """The sections of a report; window: the close-up [s], default the CLOSE_S around the largest reliable e_C.

    Raises TowlineError if the window is not within the record.
    """
    if window is not None:
        for cable in cables:
            _check_within(window, cable)
    return [Section(cable, _spreads(cable, window, _identifier(cable, i))) for i, cable in enumerate(cables)]


def _identifier(cable: Cable, number: int) -> str:
    """A name for the identifiers in the cable's figures, of letters that XML allows there."""
    return f"{number}-{re.sub('[^A-Za-z0-9]', '-', cable.recording.name)}"


def _whole(cable: Cable) -> Window:
    t_ns = cable.fits.t_ns
    return Window(float(t_ns[0] / 1e9), float(t_ns[-1] / 1e9)) if len(t_ns) else Window(0.0, 1.0)


def _check_within(window: Window, cable: Cable) -> None:
    whole = _whole(cable)
    if not whole.start <= window.start < window.end <= whole.end:
        raise TowlineError(
            f"--window: {window.start:g} to {window.end:g} s is not within the record of {cable.recording.name}, "
            f"which goes from {whole.start:.6g} to {whole.end:.6g} s"
        )


def _worst(cable: Cable) -> Window:
    """CLOSE_S around the largest reliable e_C, within the record."""
    whole, e_c = _whole(cable), np.where(reliable(cable.fits), cable.fits.e_catenary, -np.inf)
    if not np.isfinite(e_c).any():
        return Window(whole.start, min(whole.end, whole.start + CLOSE_S))
    middle = cable.fits.t_ns[np.argmax(e_c)] / 1e9
    start = max(whole.start, min(middle - CLOSE_S / 2.0, whole.end - CLOSE_S))
    return Window(start, min(start + CLOSE_S, whole.end))


def _spreads(cable: Cable, window: Window | None, name: str) -> list[Spread]:
    """The whole record, and a close-up."""
    ends = cable.recording.ends()
    close = window or _worst(cable)
    title = f"{close.start:.4g} to {close.end:.4g} s" + ("" if window else ", around the largest e_C")
    return [
        Spread("The whole record", _pictures(cable, ends, _whole(cable), f"{name}-all")),
        Spread(title, _pictures(cable, ends, close, f"{name}-close")),
    ]


def _pictures(cable: Cable, ends: Ends, window: Window, name: str) -> list[Picture]:
    return [
        Picture(
            indicators(cable, window, name),
            f"Indicators and catenary parameter. Grey: fewer than {LEAST_MARKERS} markers, not in the statistics. "
            "Red: e_C beyond the tolerance by more than noise explains.",
        ),
        Picture(
            circumstances(cable, ends, window, name),
            f"Markers and ends. Below the dashed line frames are not used. {ends.source[0].upper()}{ends.source[1:]}.",
        ),
    ]


def write(path: Path, text: str) -> None:
    """Write the page whole or not at all. Raises OSError."""
    fresh = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        fresh.write_text(text, encoding="utf-8")
        fresh.replace(path)
    finally:
        fresh.unlink(missing_ok=True)
