"""The capability rose: limiting wind over heading, the bow up, one curve a case."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.projections.polar import PolarAxes

from pipeline.capability.limits import INTACT, Capability

SIZE = 6.4  # inches
STYLE: Any = {
    "font.size": 9,
    "axes.grid": True,
    "grid.color": "#dddddd",
    "svg.fonttype": "none",
    "svg.hashsalt": "towline",
}
HELD = "#12608a"
LOST = ("#d1495b", "#e0912f", "#3c8d53", "#7b5ea7", "#5b6770", "#a0693c", "#c56fa5", "#2f9fa8")


def draw(found: Capability, title: str, out: Path) -> None:
    """Write the rose as a picture of the file's kind. Raises OSError; ValueError for a kind that is none."""
    with rc_context(STYLE):
        figure = Figure(figsize=(SIZE, SIZE), layout="constrained")
        axes = figure.add_subplot(projection="polar")
        assert isinstance(axes, PolarAxes)
        axes.set_theta_zero_location("N")
        axes.set_theta_direction(-1)
        angles = np.radians(np.append(found.headings, found.headings[0] + 360.0))
        colours = iter(LOST * (1 + len(found.winds) // len(LOST)))
        for case, winds in found.winds.items():
            closed = np.append(winds, winds[0])
            if case == INTACT:
                axes.fill(angles, closed, color=HELD, alpha=0.12)
                axes.plot(angles, closed, color=HELD, linewidth=2.0, label=case)
            else:
                axes.plot(angles, closed, color=next(colours), linewidth=1.1, label=f"{case} lost")
        axes.set_rlabel_position(112)
        axes.set_ylim(0.0, None)
        axes.set_title(
            f"{title}: wind [m/s] up to which position is held\nby the direction the weather comes from, bow up"
        )
        figure.legend(loc="outside lower center", ncols=3, frameon=False)
        figure.savefig(out, dpi=150)
