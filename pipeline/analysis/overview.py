"""One picture of a line's run: its shapes seen from the side, and what its moving end felt."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from pipeline.log.reader import open_log

SHAPES = 14  # drawn, evenly over the window
WINDOW_S = (60.0, 75.0)  # fast sweeps in slanting directions


def draw(log_path: str | Path, picture: str | Path, line: str = "tether", end: str = "hand") -> None:
    """Draw the channels `line` (nodes, tension, force_b) and `end` (motion) of a log into a picture file."""
    with open_log(log_path) as log:
        t = log.times(line) / 1e9
        nodes, force = log.port(line, "nodes"), log.port(line, "force_b")
        speed = np.linalg.norm(log.port(end, "motion.velocity"), axis=1)
    shown = (t >= WINDOW_S[0]) & (t <= WINDOW_S[1])
    figure = Figure((10.5, 4.2), layout="constrained")
    side, history = figure.subplots(1, 2, width_ratios=(1, 1.5))
    for i in np.flatnonzero(shown)[:: max(1, shown.sum() // SHAPES)]:
        share = (t[i] - WINDOW_S[0]) / (WINDOW_S[1] - WINDOW_S[0])
        side.plot(nodes[i, :, 0], nodes[i, :, 2], color=(0.1, 0.25 + 0.5 * share, 0.55), alpha=0.8, linewidth=1.2)
    side.plot(nodes[shown, -1, 0], nodes[shown, -1, 2], color="tab:orange", linewidth=1, label="the hand's path")
    side.plot(*nodes[0, 0, [0, 2]], "ks", label="fixed end")
    side.set(xlabel="north [m]", ylabel="depth [m]", title=f"{SHAPES} shapes of the chain in {np.ptp(WINDOW_S):g} s")
    side.invert_yaxis()
    side.set_aspect("equal")
    side.legend(fontsize=8, loc="lower left")
    history.plot(t[shown], np.linalg.norm(force[shown], axis=1), color="tab:blue")
    history.set(xlabel="time [s]", title="force on the hand, and its speed")
    history.set_ylabel("force [N]", color="tab:blue")
    other = history.twinx()
    other.plot(t[shown], speed[shown], color="tab:orange", linewidth=1)
    other.set_ylabel("speed [m/s]", color="tab:orange")
    figure.savefig(picture, dpi=110)
