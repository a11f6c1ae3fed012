"""A case run by CableDyn 0.3 (implicit finite elements), through its Python interface, one step a call.

A deck without a water depth has neither drag nor added mass in CableDyn, so there is always one. In a current that
varies with depth this version leaves its own equilibrium (an upper tension of 384 N falls to 324 N between still ends,
with a current from 0.8 m/s at the surface to none at 300 m); in a uniform one it stays there.
"""

import tempfile
import time
from pathlib import Path

import numpy as np
from cabledyn import CableDyn, DeckWriter
from peers.case import BOTTOMLESS, GRAVITY, POINTS, Trace, flipped

NAME = "CableDyn 0.3"


def deck(case, segments: int, step: float, options: dict[str, float | str]) -> DeckWriter:
    """The input file; CableDyn wants the moving end to be End A, so its line runs from our b to our a."""
    written = DeckWriter(title=case.name)
    written.add_line_type(
        "line",
        diam=case.diameter,
        mass=case.mass,
        ea=case.stiffness,
        ba=case.damping,
        ei=case.bending,
        cdn=case.drag_n,
        cdt=case.drag_t,
        can=case.added_n,
        cat=case.added_t,
    )
    written.add_point(1, "Coupled", *flipped(np.array(case.centre)))
    written.add_point(2, "Fixed", *flipped(np.array(case.fixed)))
    written.add_line(1, node_a=1, node_b=2)
    written.add_section(line_id=1, line_type="line", length=case.length, num_segs=segments)
    written.set_option(GRAVITY, "g")
    written.set_option(case.density, "rhoW")
    written.set_option(case.seabed.depth if case.seabed else BOTTOMLESS, "WtrDpth")
    if case.seabed:
        written.set_option(case.seabed.stiffness, "kBot")
        written.set_option(case.seabed.damping, "cBot")
    for keyword, value in options.items():
        written.set_option(value, keyword)
    if case.current or case.bending:
        written.set_option(step, "dtM")
        written.set_option(case.duration, "TMax")
    return written


def run(case, segments: int, step: float, repeats: int = 1, **options: float | str) -> Trace:
    """A Trace; its loop time is that of the step calls alone, the median of `repeats` runs."""
    position, velocity, acceleration = (flipped(m) for m in case.moving_end(case.times(step)))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "line.dat"
        text = deck(case, segments, step, options).text()
        if case.current:
            text = text.replace("--- OPTIONS ---\n", f"--- OPTIONS ---\nuniform {case.current} 0 0 current\n")
        path.write_text(text)
        runs = [_march(path, position, velocity, acceleration, step, case, segments) for _ in range(repeats)]
    samples, loops, calls = zip(*runs, strict=True)
    tension, points = (np.array(column) for column in zip(*samples[0], strict=True))
    return Trace(tension, flipped(points), float(np.median(loops)), float(np.median(calls)))


def _vectors(model, *motions):
    """The coupled vectors, with the still ends' blocks filled from the model."""
    full, driven = model.get_coupled_motion(), model.host_dofs()
    filled = []
    for start, motion in zip(full, motions, strict=True):
        rows = np.tile(start, (len(motion), 1))
        rows[:, driven] = motion
        filled.append(rows)
    return filled


def _march(path: Path, position, velocity, acceleration, step: float, case, segments: int):
    """Samples (tension, points), the time of the step calls, and that together with the equilibrium's."""
    samples, loop_s, every, stride = [], 0.0, round(case.sample / step), segments // POINTS
    began = time.thread_time()
    with CableDyn(path) as model:
        settled_s = time.thread_time() - began
        q, v, a = _vectors(model, position, velocity, acceleration)
        line = model.line(1)
        for first in range(0, len(q), every):
            # calc_output holds the still end as well, but of a line with bending stiffness the moving one only.
            forces = model.calc_output().reshape(-1, 3)
            far = line.node_tensions()[-1] if line.finite_ei else np.linalg.norm(forces[1])
            nodes = line.node_positions()[line.deck_nodes > 0]
            samples.append(((far, np.linalg.norm(forces[0])), nodes[::-1][::stride]))
            began = time.thread_time()
            for k in range(first + 1, min(first + every + 1, len(q))):
                model.step(step, q[k], v[k], a[k])
            loop_s += time.thread_time() - began
    return samples, loop_s, settled_s + loop_s
