"""A case run by MoorDyn 2.7 (explicit, lumped mass), through its Python interface, one internal step a call.

A coupled point moves at constant velocity over a call, so that a call of many steps would let the end's velocity jump,
each jump dv a blow of sqrt(EA m) dv. The end force is MoorDyn's net force on the point less the inertia of the end
node, which MoorDyn leaves to the host.
"""

import contextlib
import os
import sys
import tempfile
import time
from pathlib import Path

import moordyn
import numpy as np
from peers.case import BOTTOMLESS, GRAVITY, POINTS, Trace, flipped

NAME = "MoorDyn 2.7"
SETTLED_S, THRESHOLD = 10, 1e-8  # pseudo-time that its static solver gets [s], and when its equilibrium is good enough


def deck(case, segments: int, step: float, scheme: str) -> str:
    """The input file; end a is point 1, end b point 2."""
    a, b = flipped(np.array(case.fixed)), flipped(np.array(case.centre))
    depth = case.seabed.depth if case.seabed else BOTTOMLESS
    seabed = case.seabed
    return f"""--- MoorDyn ---
--- LINE TYPES ---
Name Diam Mass EA BA EI Cd Ca CdAx CaAx
(-) (m) (kg/m) (N) (N-s) (N-m^2) (-) (-) (-) (-)
line {case.diameter!r} {case.mass!r} {case.stiffness!r} {case.damping!r} {case.bending!r} {case.drag_n!r} \
{case.added_n!r} {case.drag_t!r} {case.added_t!r}
--- POINTS ---
ID Type X Y Z Mass Volume CdA Ca
(-) (-) (m) (m) (m) (kg) (m^3) (m^2) (-)
1 Coupled {a[0]} {a[1]} {a[2]} 0 0 0 0
2 Coupled {b[0]} {b[1]} {b[2]} 0 0 0 0
--- LINES ---
ID LineType AttachA AttachB UnstrLen NumSegs Outputs
(-) (-) (-) (-) (m) (-) (-)
1 line 1 2 {case.length!r} {segments} -
--- OPTIONS ---
0 writeLog
1 disableOutput
1 disableOutTime
{step!r} dtM
{scheme} tScheme
{case.density!r} WtrDnsty
{GRAVITY} g
{depth} WtrDpth
{seabed.stiffness if seabed else 1e5} kBot
{seabed.damping if seabed else 1e4} cBot
{int(case.current != 0.0)} Currents
{int(case.relax > 0)} ICgenDynamic
{case.relax or SETTLED_S} TmaxIC
{THRESHOLD} threshIC
10 dtIC
1 CdScaleIC
--- END ---
"""


@contextlib.contextmanager
def silence():
    """Keep what the library writes to file descriptors 1 and 2 from the terminal."""
    sys.stdout.flush()
    kept = os.dup(1), os.dup(2)
    nothing = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nothing, 1)
        os.dup2(nothing, 2)
        yield
    finally:
        for descriptor, copy in zip((1, 2), kept, strict=True):
            os.dup2(copy, descriptor)
            os.close(copy)
        os.close(nothing)


def run(case, segments: int, step: float, repeats: int = 1, scheme: str = "RK4") -> Trace:
    """A Trace; its loop time is that of the Step calls alone, the median of `repeats` runs from one equilibrium."""
    times = case.times(step)
    position, _, acceleration = case.moving_end(times)
    x = np.hstack([np.tile(flipped(np.array(case.fixed)), (len(times), 1)), flipped(position)])
    v = (np.diff(x, axis=0) / step).tolist()
    every = round(case.sample / step)
    with tempfile.TemporaryDirectory() as name, silence():
        folder = Path(name)
        (folder / "line.txt").write_text(deck(case, segments, step, scheme))
        if case.current:
            (folder / "current_profile.txt").write_text(_profile(case.current))
        settled_s = _settle(folder, x[0].tolist())
        loops = []
        for _ in range(repeats):
            samples, loop_s = _march(folder, x.tolist(), v, flipped(acceleration), step, every, segments)
            loops.append(loop_s)
    tension, points = (np.array(column) for column in zip(*samples, strict=True))
    loop_s = float(np.median(loops))
    return Trace(tension, flipped(points), loop_s, settled_s + loop_s)


def _profile(speed: float) -> str:
    """The file of a current; its heights must ascend."""
    return f"--- current ---\nz ux uy uz\n(m) (m/s) (m/s) (m/s)\n{-BOTTOMLESS} {speed} 0 0\n0 {speed} 0 0\n"


def _settle(folder: Path, x0: list[float]) -> float:
    """Find the equilibrium and keep it in a file; the time that took."""
    began = time.thread_time()
    system = moordyn.Create(str(folder / "line.txt"))
    moordyn.Init(system, x0, [0.0] * 6)
    took = time.thread_time() - began
    moordyn.Save(system, str(folder / "settled"))
    moordyn.Close(system)
    return took


def _march(folder: Path, x, v, acceleration, step: float, every: int, segments: int):
    """Samples (tension, points) and the time of the Step calls."""
    system = moordyn.Create(str(folder / "line.txt"))
    moordyn.Init_NoIC(system, x[0], [0.0] * 6)
    moordyn.Load(system, str(folder / "settled"))
    line, moving = moordyn.GetLine(system, 1), moordyn.GetPoint(system, 2)
    nodes = range(0, segments + 1, segments // POINTS)
    samples, loop_s = [], 0.0

    def read(k: int, forces) -> None:
        b = np.array(forces[3:]) - np.array(moordyn.GetPointM(moving)) @ acceleration[k]
        points = [moordyn.GetLineNodePos(line, i) for i in nodes]
        samples.append(([np.linalg.norm(forces[:3]), np.linalg.norm(b)], points))

    forces = moordyn.Step(system, x[0], [0.0] * 6, 0.0, 0.0)
    for first in range(0, len(v) + 1, every):
        read(first, forces)
        began = time.thread_time()
        for k in range(first, min(first + every, len(v))):
            forces = moordyn.Step(system, x[k], v[k], k * step, step)
        loop_s += time.thread_time() - began
    moordyn.Close(system)
    return samples, loop_s
