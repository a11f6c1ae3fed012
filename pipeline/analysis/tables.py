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


def behind(cable: Cable) -> str:
    """One sentence: how many frames stand behind the statistics, or why there are none."""
    s = cable.statistics
    if s.missing:
        return f"{s.missing[0].upper()}{s.missing[1:]}."
    return f"{s.frames_used} of {s.frames} frames stand behind the statistics."


def failures(cable: Cable) -> str:
    """Sentences: frames behind the statistics, how much of the time the catenary fails, how much is not known."""
    failing = sum(span.frames for span in cable.spans)
    used, frames = cable.statistics.frames_used, cable.statistics.frames
    share = f" ({100.0 * failing / used:.3g} %)" if used else ""
    return (
        f"{behind(cable)} "
        f"e_C exceeds {1e3 * cable.tolerance:.4g} mm in {failing} of {used} frames{share}, "
        f"by more than noise explains, {len(cable.spans)} spans; "
        f"of {frames - used} frames nothing is known (fewer than {LEAST_MARKERS} markers, or no fit). "
        f"Length {cable.length:.4g} m ({cable.length_source})."
    )


def noise(cable: Cable) -> str:
    """Sentences: what the markers' noise alone would give, where it is known, and what noise and drop-out add."""
    sentences = []
    if cable.noise is not None:
        n = cable.noise
        sentences.append(
            f"Markers with {n.marker_mm:.3g} mm of noise on a true catenary would give e_P {n.e_plane_mm:.3g} mm and "
            f"e_C {n.e_catenary_mm:.3g} mm; α is then uncertain by {n.alpha_deg:.2g}°, C by {n.C_per_m:.2g}/m "
            "(medians)."
        )
    for cause, shifts in (("noise", cable.biases.noise), ("drop-out", cable.biases.drop_out)):
        if shifts is not None:
            sentences.append(
                f"Bias of the means by {cause}: α {shifts.alpha_deg:+.2g}°, e_P {shifts.e_plane_mm:+.2g} mm, "
                f"e_C {shifts.e_catenary_mm:+.2g} mm."
            )
    return " ".join(sentences)
