"""Figures 4 to 8 of van Daalen et al. 2011 drawn anew from scenarios/semisub_allocation.yaml, and what they tell."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.log.reader import Log, open_log
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph

ROOT = Path(__file__).parents[2]
FIGURE = ROOT / "docs" / "semisub_allocation.svg"
MOST = 496.0  # [kN], of each thruster
METHODS = {"quadratic": "#999999", "newton": "#c46210", "published": "#7a4fa3", "exact": "#0b6e99"}
PLACES = ((-41.0, -14.0, 14.0, 41.0) * 2, (-28.0,) * 4 + (28.0,) * 4)
THRUSTERS = [f"{side}{i}" for side in ("PS", "SB") for i in range(1, 5)]
AXES = ("surge [MN]", "sway [MN]", "yaw [MN m]")
Row = dict[str, str | float]


def totals(log: Log, name: str, most: float = np.inf) -> np.ndarray:
    """(k, 3) surge, sway [MN] and yaw [MN m] of a method's commands, thrusts cut off at `most` [kN]."""
    thrust, azimuth = np.minimum(log.port(name, "thrust"), 1e3 * most) * 1e-6, log.port(name, "azimuth")
    fx, fy = thrust * np.cos(azimuth), thrust * np.sin(azimuth)
    x, y = PLACES
    return np.column_stack([fx.sum(axis=1), fy.sum(axis=1), (x * fy - y * fx).sum(axis=1)])


def demand(log: Log) -> np.ndarray:
    """(k, 3) what is required, in the same units."""
    return np.column_stack([log.port("demand", "demand.force"), log.port("demand", "demand.moment")]) * 1e-6


def draw(log: Log, path: Path) -> None:
    """Totals above, thrusts of the eight below, then azimuths, power and what is missed."""
    figure = Figure(figsize=(12.0, 9.0), layout="constrained")
    panels = figure.subplots(3, 3)
    t, required = log.times("demand") * 1e-9, demand(log)
    truncated = totals(log, "newton", MOST)
    for ax, name, k in zip(panels[0], AXES, range(3), strict=True):
        ax.plot(t, required[:, k], color="black", linewidth=2.5, label="required, and without limits")
        ax.plot(t, truncated[:, k], color=METHODS["newton"], linestyle="--", label="without limits, then cut off")
        ax.plot(t, totals(log, "published")[:, k], color=METHODS["published"], linewidth=1.0, label="published")
        ax.plot(t, totals(log, "exact")[:, k], color=METHODS["exact"], linewidth=1.0, label="exact")
        _name(ax, f"total {name.split()[0]}", name)
    panels[0][0].legend(frameon=False, fontsize=8, loc="upper right")
    titles = ("without limits (newton)", "published loop over limits", "exact")
    for ax, name, title in zip(panels[1], ("newton", "published", "exact"), titles, strict=True):
        ax.plot(t, log.port(name, "thrust") * 1e-3, linewidth=1.0, label=THRUSTERS)
        ax.axhline(MOST, color="black", linewidth=0.8, linestyle=":")
        ax.set_ylim(0.0, 800.0)
        _name(ax, title, "thrust [kN]")
    panels[1][0].legend(frameon=False, fontsize=7, ncols=4)
    panels[2][0].plot(t, np.degrees(log.port("exact", "azimuth")), linewidth=1.0, label=THRUSTERS)
    _name(panels[2][0], "exact", "azimuth [deg]")
    for name, colour in METHODS.items():
        panels[2][1].plot(t, log.port(name, "power").sum(axis=1) * 1e-6, color=colour, linewidth=1.0, label=name)
    _name(panels[2][1], "power", "sum of all [MW]")
    panels[2][1].legend(frameon=False, fontsize=8)
    for name in ("published", "exact"):
        miss = np.linalg.norm((totals(log, name, MOST) - required)[:, :2], axis=1) * 1e3
        panels[2][2].plot(t, miss, color=METHODS[name], linewidth=1.0, label=name)
    miss = np.linalg.norm((truncated - required)[:, :2], axis=1) * 1e3
    panels[2][2].plot(t, miss, color=METHODS["newton"], linestyle="--", linewidth=1.0, label="without limits")
    _name(panels[2][2], "missed, thrusts cut off at their largest", "force [kN]")
    panels[2][2].legend(frameon=False, fontsize=8)
    with rc_context({"svg.hashsalt": "towline"}):  # the same data give the same file
        figure.savefig(path, metadata={"Date": None})


def _name(ax: Axes, title: str, quantity: str) -> None:
    ax.set_title(title, fontsize=10)
    ax.set_xlabel("time [s]")
    ax.set_ylabel(quantity)
    ax.grid(True, linewidth=0.3)


def rows() -> list[Row]:
    """One row a method; the figure is drawn anew."""
    scenario = load_scenario(ROOT / "scenarios" / "semisub_allocation.yaml")
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run.mcap"
        run_scenario(scenario, build_graph(scenario), out, Options(scene=False), lambda _: None)
        log = open_log(out)
        draw(log, FIGURE)
        return [_row(log, name) for name in METHODS]


def _row(log: Log, name: str) -> Row:
    required = demand(log)
    miss = np.linalg.norm((totals(log, name, MOST) - required)[:, :2], axis=1)
    return {
        "case": "semisub_allocation",
        "method": name,
        "error": float(miss.max() / np.linalg.norm(required[:, :2], axis=1).max()),
        "error_unit": "largest miss of force over the largest demand, thrusts cut off at their largest",
        "yaw_missed": float(np.abs((totals(log, name, MOST) - required)[:, 2]).max() / np.abs(required[:, 2]).max()),
        "overload": float(log.port(name, "thrust").max() * 1e-3 / MOST),
        "power_MW": float(log.port(name, "power").sum(axis=1).mean() * 1e-6),
        "reference": "the demand",
    }
