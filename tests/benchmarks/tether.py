"""Work-precision of line dynamics: Towline beside MoorDyn and CableDyn on the same physics, in one run and one thread.

`pip install "towline[peers]"` brings the two; without them there are rows of Towline alone. Errors are rms over the
samples of a run: of the tension at both ends, in percent of its rms, and of ten material points. They are against a
common reference, Towline extrapolated to no segment length from its two finest runs (the three codes agree on it to
the error that their own finest rows show; the snap converges at no clean order, there it is the finest run itself), and
against the code's own finest run.

The cases' laws differ between the codes in one thing: in a slack segment the peers' axial damping goes on acting,
Towline's tension is max(0, EA (e + tau de/dt)).
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before CableDyn's library is loaded

import importlib
import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator
from peers import towline_line
from peers.case import Case, Seabed, Trace

FIGURE = Path(__file__).parents[2] / "docs" / "tether_work_precision.svg"
REPEATS = 3
SLOW_S = 4.0  # a run that takes longer than this is made once
STILL = (0.0, 0.0, 0.0)

# 3.5 m of chain of 10 mm (0.092 kg/m in fresh water) between two points 2 m apart, one on a level circle. BA is such
# that the lowest axial wave loses 1.5 % of critical: enough to forget the start, too little to see otherwise.
CHAIN = Case(
    name="pool chain", length=3.5, mass=0.1705, diameter=0.01, stiffness=5e5, damping=10.0,
    fixed=(0.0, 0.0, 1.0), centre=(2.0, 0.0, 1.0), cosine=(0.25, 0.0, 0.0), sine=(0.0, 0.25, 0.0), frequency=0.5,
    ramp=2.0, duration=9.0, sample=0.1,
)  # fmt: skip
# A nearly neutral ROV tether, ROV at 260 m and 60 m down the current, the ship's end heaving 1 m each 10 s. The current
# is uniform, for in a sheared one CableDyn does not keep its equilibrium (peers/cabledyn_line.py).
TETHER = Case(
    name="ROV tether", length=300.0, mass=0.35, diameter=0.02, stiffness=2e5, damping=1e3, drag_t=0.02, density=1025.0,
    fixed=(60.0, 0.0, 260.0), centre=(0.0, 0.0, 10.0), cosine=(0.5, 0.0, 0.0), sine=(0.0, 0.0, 1.0), frequency=0.1,
    ramp=10.0, duration=40.0, sample=0.4, current=0.4, relax=800,
)  # fmt: skip
# A power cable in 60 m of water, anchored, its lower half on the bed; its upper end hinged on a vessel that goes round.
# The bed is stiff, for Towline's sets in smoothly and lets the line sink by twice the peers' weight over stiffness
# (0.8 mm here), and undamped, for their dampings differ. The motion is such that no part of the line is compressed: the
# anchor's tension stays above 230 N. Where some is, with 1.0 m by 50 N for half a second, Towline and CableDyn carry it
# as a beam does; MoorDyn's segments go slack and snap taut 0.5 s later by 200 N, which makes 2.1 % of difference (and
# 1.8 % between Towline with and without `tension_only`). Step, segments, stiffness and damping of the bed, axial
# damping and friction change nothing of that; half the motion, half the frequency or no bed leave 0.3, 0.13 and 0.02 %.
RISER = Case(
    name="catenary riser", length=120.0, mass=12.0, diameter=0.1, stiffness=5e6, damping=1e4, density=1025.0,
    fixed=(0.0, 0.0, 60.0), centre=(90.0, 0.0, 8.0), cosine=(0.8, 0.0, 0.0), sine=(0.0, 0.0, 0.8), frequency=0.1,
    ramp=10.0, duration=40.0, sample=0.4, bending=1e4, seabed=Seabed(60.0, 1e6, 0.0), relax=100,
)  # fmt: skip
# A rope pulled taut and let slack each two seconds: tension from nothing to 350 N in 0.2 s; damped 5 % as fibre ropes.
SNAP = Case(
    name="snap", length=10.0, mass=0.2, diameter=0.012, stiffness=2e4, damping=20.0,
    fixed=(0.0, 0.0, 5.0), centre=(9.5, 0.0, 5.0), cosine=STILL, sine=(0.6, 0.0, 0.0), frequency=0.5,
    ramp=2.0, duration=6.0, sample=0.02,
)  # fmt: skip

# Segments and step [s] of every run: Towline's, those its reference is from, CableDyn's, MoorDyn's. Steps are the
# largest that lose little against a smaller one; MoorDyn's RK4, its cheapest scheme here, is stable up to about a third
# more.
Runs = tuple[tuple[int, float], ...]
COARSE: Runs = tuple((n, h) for n in (10, 20, 30, 40, 50, 70, 100, 150, 200) for h in (0.1, 0.05, 0.02))
SHARP: Runs = tuple((n, h) for n in (10, 20, 50, 100, 200) for h in (0.02, 0.01, 0.005, 0.002, 0.001))
PLAN: dict[str, tuple[Case, Runs, Runs, Runs, Runs]] = {
    "chain": (
        CHAIN, (*COARSE, (200, 0.01), (300, 0.01), (300, 0.005)), ((200, 0.0025), (400, 0.0025)),
        ((10, 0.05), (20, 0.02), (50, 0.01), (100, 0.005)), ((10, 2e-4), (20, 1e-4), (50, 4e-5), (100, 2e-5)),
    ),
    "tether": (
        TETHER, (*COARSE, (300, 0.1), (300, 0.05)), ((200, 0.005), (400, 0.005)),
        ((10, 0.1), (20, 0.1), (50, 0.05), (100, 0.02)), ((10, 8e-3), (20, 8e-3), (50, 4e-3), (100, 2e-3)),
    ),
    "riser": (
        RISER, COARSE, ((200, 0.005), (400, 0.005)),
        ((20, 0.1), (40, 0.05), (80, 0.05), (160, 0.02)), ((20, 2e-3), (40, 2e-3), (80, 1e-3), (160, 4e-4)),
    ),
    "snap": (
        SNAP, SHARP, ((400, 0.0002),),
        ((10, 0.005), (20, 0.005), (50, 0.002), (100, 0.001)), ((10, 2e-3), (20, 1e-3), (50, 2e-4), (100, 5e-5)),
    ),
}  # fmt: skip


def peers() -> list[ModuleType]:
    """The modules that run the peers which are installed."""
    wanted = {"cabledyn": "peers.cabledyn_line", "moordyn": "peers.moordyn_line"}
    return [importlib.import_module(name) for package, name in wanted.items() if importlib.util.find_spec(package)]


def timed(module: ModuleType, case: Case, segments: int, step: float) -> Trace:
    """A run, made REPEATS times if it is not slow; what it leaves is the same each time, its time the median."""
    once = module.run(case, segments, step)
    return once if once.loop_s > SLOW_S else module.run(case, segments, step, REPEATS)


def extrapolated(coarse: Trace, fine: Trace) -> Trace:
    """Richardson's: without the error that halving the segments cut to a quarter (see `towline bench tether_order`)."""
    return Trace(
        fine.tension + (fine.tension - coarse.tension) / 3, fine.points + (fine.points - coarse.points) / 3, 0, 0
    )


def tension_error(run: Trace, reference: Trace) -> float:
    """Rms of the difference at both ends in percent of the reference's rms."""
    return 100 * float(np.sqrt(np.mean((run.tension - reference.tension) ** 2) / np.mean(reference.tension**2)))


def position_error(run: Trace, reference: Trace) -> float:
    """Rms distance of the material points [mm]."""
    return 1e3 * float(np.sqrt(np.mean(np.sum((run.points - reference.points) ** 2, axis=-1))))


def row(case: Case, name: str, n: int, h: float, run: Trace, reference: Trace | None, own: Trace) -> dict:
    """One line of the table; reference: the common one, None if Towline cannot run the case."""
    common = reference or own
    return {
        "case": case.name,
        "method": name,
        "segments": n,
        "step_ms": 1e3 * h,
        "error": tension_error(run, common),
        "error_unit": "% of the end tensions, rms",
        "position_error_mm": position_error(run, common),
        "own_error": tension_error(run, own),
        "real_time_factor": case.duration / run.loop_s,
        "call_s": run.call_s,
        "reference": "Towline" if reference else "own finest run",
    }


def front(rows: list[dict]) -> list[dict]:
    """The rows than which no other has both a smaller error and a shorter time, fastest first."""
    kept, best = [], np.inf
    for r in sorted(rows, key=lambda r: -r["real_time_factor"]):
        if r["error"] < best:
            kept.append(r)
            best = r["error"]
    return kept


def compared(rows: list[dict]) -> None:
    """Tell each peer's row how many times faster Towline's fastest run is that errs no more, if there is one."""
    own = [r for r in rows if r["method"] == towline_line.NAME]
    for r in rows:
        if r["method"] != towline_line.NAME and own:
            as_good = [o["real_time_factor"] for o in own if o["error"] <= r["error"]]
            both = [
                o["real_time_factor"]
                for o in own
                if o["error"] <= r["error"] and o["position_error_mm"] <= r["position_error_mm"]
            ]
            r["towline_faster"] = max(as_good) / r["real_time_factor"] if as_good else None
            r["towline_faster_also_in_position"] = max(both) / r["real_time_factor"] if both else None


def rows_of(case: Case, towline: Runs, references: Runs, cabledyn: Runs, moordyn: Runs) -> list[dict]:
    """Every run of a case, Towline's front alone of its many."""
    table, reference, lacking = [], None, towline_line.lacks(case)
    if lacking:
        table.append({"case": case.name, "method": towline_line.NAME, "note": f"tether.cable has no {lacking} yet"})
    else:
        pair = [towline_line.run(case, n, h) for n, h in references]
        reference = extrapolated(*pair) if len(pair) == 2 else pair[-1]
        runs = [timed(towline_line, case, n, h) for n, h in towline]
        named = zip(towline, runs, strict=True)
        table += front([row(case, towline_line.NAME, n, h, run, reference, pair[-1]) for (n, h), run in named])
    for module in peers():
        steps = {"CableDyn 0.3": cabledyn, "MoorDyn 2.7": moordyn}[module.NAME]
        runs = [timed(module, case, n, h) for n, h in steps]
        for (n, h), run in zip(steps, runs, strict=True):
            table.append(row(case, module.NAME, n, h, run, reference, runs[-1]))
    if not lacking:
        compared(table)
    return table


def draw(table: list[dict], path: Path) -> None:
    """A panel a case: error against processor time per simulated second."""
    cases = list(dict.fromkeys(r["case"] for r in table))
    figure = Figure(figsize=(3.2 * len(cases), 3.2), layout="constrained")
    axes = figure.subplots(1, len(cases), squeeze=False)
    styles = {"Towline": ("o-", "#0b6e99"), "CableDyn 0.3": ("s--", "#c46210"), "MoorDyn 2.7": ("^:", "#555555")}
    for ax, case in zip(axes[0], cases, strict=True):
        for method, (style, colour) in styles.items():
            shown = [r for r in table if r["case"] == case and r["method"] == method and "error" in r]
            if shown:
                x, y = [1 / r["real_time_factor"] for r in shown], [r["error"] for r in shown]
                ax.loglog(x, y, style, color=colour, label=method, markersize=4, linewidth=1.2)
        ax.set_title(case, fontsize=10)
        ax.set_xlabel("processor time / simulated time")
        ax.grid(True, which="major", linewidth=0.3)
        ax.yaxis.set_major_formatter("{x:g}")
        ax.yaxis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))
        ax.yaxis.set_minor_formatter("{x:g}")
        ax.tick_params(axis="y", which="minor", labelsize=7)
    axes[0][0].set_ylabel("end tension error, rms [%]")
    figure.legend(*axes[0][0].get_legend_handles_labels(), loc="outside upper center", ncols=3, frameon=False)
    with rc_context({"svg.hashsalt": "towline"}):  # the same data give the same file
        figure.savefig(path, metadata={"Date": None})


def rows() -> list[dict]:
    """All cases; with both peers installed the figure is drawn anew."""
    table = [r for plan in PLAN.values() for r in rows_of(*plan)]
    if len(peers()) == 2:
        draw(table, FIGURE)
    else:
        table.append({"method": "peers", "note": 'not installed: pip install "towline[peers]" (moordyn, cabledyn)'})
    return table
