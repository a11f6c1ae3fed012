"""The tables of a cable's validity as texts: the same on the terminal and on the page."""

from __future__ import annotations

from collections.abc import Iterator

from pipeline.analysis.statistics import LEAST_MARKERS, Summary
from pipeline.analysis.validity import Cable

# Fields of Statistics and Published, and their columns' titles, as in Tables II and III of Drupt et al. 2022.
INDICATORS = {"alpha_deg": "α [°]", "e_plane_mm": "e_P [mm]", "e_catenary_mm": "e_C [mm]"}
ROWS = {"mean": "mean", "min": "min", "max": "max", "median": "median", "std": "σ"}
MISSING = "-"


def shown(summary: Summary | None, row: str) -> str:
    """A figure with three digits, as the paper's."""
    return MISSING if summary is None else f"{getattr(summary, row):.3g}"


def rows(cable: Cable) -> Iterator[tuple[str, list[str]]]:
    """Name and values of each row; after each indicator the published figure, where there is one."""
    for row, name in ROWS.items():
        values = []
        for indicator in INDICATORS:
            values.append(shown(getattr(cable.statistics, indicator), row))
            if cable.published is not None:
                values.append(shown(getattr(cable.published, indicator), row))
        yield name, values


def failures(cable: Cable) -> str:
    """One sentence: how much of the time the catenary fails the tolerance, and how much is not known."""
    failing = sum(span.frames for span in cable.spans)
    used, frames = cable.statistics.frames_used, cable.statistics.frames
    share = f" ({100.0 * failing / used:.3g} %)" if used else ""
    return (
        f"e_C exceeds {1e3 * cable.tolerance:.4g} mm in {failing} of {used} frames{share}, {len(cable.spans)} spans; "
        f"of {frames - used} frames nothing is known (fewer than {LEAST_MARKERS} markers, or no fit). "
        f"Length {cable.length:.4g} m ({cable.length_source})."
    )


def noise(cable: Cable) -> str:
    """One sentence: what the markers' noise alone would give; "" where it is not known."""
    if cable.noise is None:
        return ""
    n = cable.noise
    return (
        f"Markers with {n.marker_mm:.3g} mm of noise on a true catenary would give e_P {n.e_plane_mm:.3g} mm and "
        f"e_C {n.e_catenary_mm:.3g} mm; α is then uncertain by {n.alpha_deg:.2g}°, C by {n.C_per_m:.2g}/m (medians)."
    )
