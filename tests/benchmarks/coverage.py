"""Coverage by a towed line: the optimum of Bhattacharya et al. 2011, eq. 26, for four laws of drag, and with boats.

The steady line's equations are integrated, and the closed forms are the reference. With the boats' own limits, of
scenarios/parameters/boom_boat*.yaml, the line is that of the paper's trials; thrust falls with speed, hulls resist, and
the boats push outwards as far as the line pulls inwards. The figure redraws 10a and 10b.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.optimize import minimize_scalar

from components.contract import Parameters
from components.thrusters.propulsion.model import Propulsion
from components.vessel.low_speed.model import LowSpeed
from pipeline.analysis.coverage import exact
from pipeline.analysis.coverage.boats import Boat, boat_of, speed
from pipeline.analysis.coverage.drag import ACROSS, EQUAL, LAWS, QUADRATIC, QUADRATIC_ACROSS, Drag
from pipeline.analysis.coverage.optimum import Optimum, optimum, rate
from pipeline.analysis.coverage.steady import Tow, shape, tow
from pipeline.analysis.coverage.swept import area
from pipeline.parameters import build, gather
from pipeline.yaml_source import Table, parse

ROOT = Path(__file__).parents[2]
FIGURE = ROOT / "docs" / "coverage.svg"
LENGTH, DIAMETER, DENSITY, C_D = 18.288, 0.01905, 1000.0, 1.2  # of the trials' rope [m, m], fresh water [kg/m^3]
PUBLISHED_C = 0.05  # N s/m^2: c_S of the paper, which holds near a Reynolds number of 100
MORISON = 0.5 * DENSITY * C_D * DIAMETER
ROPE = Drag("quadratic, along 3 % of across", 2, 0.03)  # pi C_t / C_D of a rough rope with C_t = 0.0115
COLOURS = ("#12608a", "#3c8d53", "#d1495b", "#e0912f", "#5b6770")
STYLE = {"font.size": 9, "axes.grid": True, "grid.color": "#e4e4e4", "svg.fonttype": "none", "svg.hashsalt": "towline",
         "axes.spines.top": False, "axes.spines.right": False}  # fmt: skip
Row = dict[str, str | float]


def parameters_of(kind: type[Parameters], *names: str):
    """The parameters of files beside the scenarios."""
    files = ", ".join(f"parameters/{name}.yaml" for name in names)
    table, problems = parse(f"file: [{files}]", names[0])
    assert isinstance(table, Table)
    found = build(kind, gather(kind, table, ROOT / "scenarios", "", problems), table.place, "", problems)
    assert not problems, problems
    return found


def boat() -> Boat:
    """The boat of the parameter files."""
    return boat_of(
        parameters_of(Propulsion, "boom_boat_thrusters"), parameters_of(LowSpeed, "boom_boat_linear", "boom_boat")
    )


def curve(drag: Drag) -> list[Tow]:
    """Tows from nearly together to nearly taut."""
    return [tow(drag, float(apex)) for apex in np.geomspace(1e-3, 4.0, 120)]


def theory(drag: Drag) -> Row:
    """The optimum of eq. 26 by integration, and how far it and the curve of forces are from the closed form."""
    found, expected = optimum(drag), exact.optimum(drag)
    error = max(abs(one.force - exact.tow(drag, exact.u_at(drag, one.separation)).force) for one in curve(drag)[40:])
    row: Row = {"case": drag.name, "method": "eq. 26 integrated", "reference": "closed form"}
    if found is None or expected is None:
        assert found is expected, "one of them has an optimum"
        row |= {"D/L": "none", "rate": "grows as D/L falls, to pi f/c"}
    else:
        error = max(error, abs(found.separation - expected.separation), abs(found.rate - expected.rate))
        unit = "f/c" if drag.power == 1 else "sqrt(f L/k)"
        row |= {"D/L": found.separation, "rate": f"{found.rate:.6f} {unit}"}
    return row | {"error": error, "error_unit": "of D/L, rate, f/(c v^p L)"}


def limited(one: Boat, drag: Drag, coefficient: float) -> Row:
    """The best separation with the boats' limits; against that if the bollard pull were there at any speed."""

    def towed(e: float) -> tuple[Tow, float]:
        line = tow(drag, float(np.exp(e)))
        return line, speed(one, drag, coefficient, LENGTH, line)

    def lost(e: float) -> float:
        line, v = towed(e)
        return -line.separation * v

    best = minimize_scalar(lost, bounds=(np.log(0.02), np.log(4.0)), method="bounded", options={"xatol": 1e-7})
    line, v = towed(best.x)
    free = optimum(drag)
    scale = (one.thrust(0.0) / coefficient) ** (1 / drag.power) * LENGTH ** (1 - 1 / drag.power)
    bollard = "none" if free is None else f"{free.rate * scale:.4g} m2/s at D/L {free.separation:.3f}"
    where = " (as wide as searched)" if v == one.fastest else ""
    return {"case": f"boats, {drag.name}", "D/L": f"{line.separation:.4f}{where}",
            "method": "eq. 26 with thrust(v), hulls",
            "rate": f"{-best.fun * LENGTH:.4g} m2/s at {v:.3g} m/s", "error": 1e-7, "error_unit": "of D/L (search)",
            "reference": f"bollard pull at any speed: {bollard}"}  # fmt: skip


def simulated() -> Row:
    """A steady line of the best shape towed by 2 L: what the union of its quadrilaterals comes to."""
    best = exact.optimum(EQUAL)
    assert best is not None
    line = LENGTH * shape(EQUAL, best.separation, 81)
    way = np.linspace(0.0, 2.0 * LENGTH, 401)
    found = area(line[None] + np.stack([0.0 * way, way], axis=1)[:, None])
    expected = best.separation * LENGTH * way[-1]
    return {"case": "steady line over 2 L", "method": "union of quadrilaterals", "D/L": best.separation,
            "rate": f"{found:.6g} m2", "error": abs(found / expected - 1.0), "error_unit": "of the area",
            "reference": "D times the way"}  # fmt: skip


def draw(one: Boat, path: Path) -> None:
    """Force and rate over separation, figures 10a and 10b, and the boats' own rate."""
    with rc_context(STYLE):
        figure = Figure(figsize=(10.5, 3.4), layout="constrained")
        force, free, real = figure.subplots(1, 3)
        for drag, colour in zip((*LAWS, ROPE), COLOURS, strict=True):
            tows = curve(drag)
            d = [line.separation for line in tows]
            if drag in LAWS:
                style = "--" if drag == QUADRATIC else "-"  # the force on it is that of the linear one
                force.plot(d, [line.force for line in tows], style, color=colour, label=drag.name)
                free.plot(d, [rate(drag, line) for line in tows], color=colour)
                mark(free, exact.optimum(drag), colour)
            if drag.power == 2:
                v = [speed(one, drag, MORISON, LENGTH, line) for line in tows]
                real.plot(d, LENGTH * np.multiply(d, v), color=colour, label=drag.name)
        force.set(xlabel="D/L", ylabel="$f_0$ / ($c\\,v^p L$)", ylim=(0.0, 2.0), title="force on each boat")
        force.legend(fontsize=8, frameon=False)
        free.set(xlabel="D/L", ylabel="$\\Phi$ / ($f_{max}/c$ or $\\sqrt{f_{max}L/c}$)", ylim=(0.0, 3.3),
                 title="area per time at a given pull")  # fmt: skip
        real.set(xlabel="D/L", ylabel="m²/s", ylim=(0.0, None),
                 title=f"two boats of {one.thrust(0.0):.0f} N, {LENGTH:.1f} m of rope")  # fmt: skip
        real.legend(fontsize=8, frameon=False)
        for axes in (force, free, real):
            axes.set_xlim(0.0, 1.0)
        figure.savefig(path, metadata={"Date": None})


def mark(axes: Axes, best: Optimum | None, colour: str) -> None:
    """The optimum, where there is one."""
    if best is not None:
        axes.plot(best.separation, best.rate, "o", color=colour, markersize=4)
        axes.annotate(f"{best.separation:.4f}", (best.separation, best.rate), (0, -12), fontsize=8, color=colour,
                      textcoords="offset points", ha="center")  # fmt: skip


def rows() -> list[Row]:
    """Each law by theory, then with the boats; the figure is drawn anew."""
    one = boat()
    table = [theory(drag) for drag in LAWS]
    table += [limited(one, drag, MORISON) for drag in (QUADRATIC_ACROSS, ROPE, QUADRATIC)]
    table += [limited(one, drag, PUBLISHED_C) for drag in (EQUAL, ACROSS)]
    table.append(simulated())
    draw(one, FIGURE)
    return table
