"""What a term that is switched off costs: a step of the plain cable here beside one of the cable before there were any.

The cable of commit BEFORE, which had no terms to switch, is taken out of the repository's history into a temporary
folder and stepped by a process of its own, turn by turn with a process of this tree, on the same pool chain. Where the
two end in the same bits the term-free arithmetic is untouched.
"""

import io
import json
import os
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

BEFORE = "760538a"
ROOT = Path(__file__).parents[2]
TURNS = 7
SEGMENTS, STEP_MS, STEPS = 50, 20, 3000

# Run in each tree: the plain cable between a still end and one on a circle, stepped by its C entry point; prints the
# processor time a step and the last state's sum and end force.
PROGRAM = """
import ctypes, json, math, time
import numpy as np
from components.compiled import bind
from components.tether.cable.component import COMPONENT
cable = COMPONENT.parameters(length=3.5, segments={segments}, mass_per_length=0.1705, volume_per_length=7.854e-5,
    drag_diameter=0.01, axial_stiffness=5e5, damping_time=2e-5, tangential_drag=0.05, fluid_density=1000.0)
p = COMPONENT.pack(cable)
u, x, y, w = (np.zeros(int(n)) for n in p[1:5])
kind = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * 5)
entry = bind(COMPONENT)
init, step = kind(entry.init), kind(entry.step)
vectors = [v.ctypes.data for v in (p, u, x, y, w)]
dt = {step_ms} * 10**6
def drive(t):
    a = math.pi * t
    u[9:12] = 2.0 + 0.25 * math.cos(a) - 0.25, 0.25 * math.sin(a), 0.0
    u[12:15] = -0.25 * math.pi * math.sin(a), 0.25 * math.pi * math.cos(a), 0.0
    u[15:18] = -0.25 * math.pi**2 * math.cos(a), -0.25 * math.pi**2 * math.sin(a), 0.0
drive(0.0)
init(0, dt, *vectors)
spent = 0.0
for k in range(1, {steps} + 1):
    drive(k * dt * 1e-9)
    began = time.thread_time_ns()
    status = step(k * dt, dt, *vectors)
    spent += time.thread_time_ns() - began
    assert status == 0
nodes = 3 * ({segments} + 1)
print(json.dumps({{"us": spent / {steps} / 1e3, "nodes": y[:nodes].tobytes().hex(), "shape": y[:nodes].tolist()}}))
"""


def _checked_out(folder: Path) -> Path:
    archive = subprocess.run(
        ["git", "archive", BEFORE, "components"], cwd=ROOT, check=True, capture_output=True, timeout=60
    )
    with tarfile.open(fileobj=io.BytesIO(archive.stdout)) as tar:
        tar.extractall(folder, filter="data")
    return folder


def _turn(tree: Path) -> dict:
    program = PROGRAM.format(segments=SEGMENTS, step_ms=STEP_MS, steps=STEPS)
    environment = {**os.environ, "PYTHONPATH": str(tree)}
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, cwd=tree, env=environment, check=True, capture_output=True, timeout=600)
    return json.loads(done.stdout)


def rows() -> list[dict]:
    """One row a tree; times are the least of the turns, which other work on the machine disturbed least."""
    with tempfile.TemporaryDirectory() as name:
        trees = {f"before any term ({BEFORE})": _checked_out(Path(name)), "terms switched off": ROOT}
        for tree in trees.values():
            _turn(tree)  # compiles
        turns = [{label: _turn(tree) for label, tree in trees.items()} for _ in range(TURNS)]
    before, after = trees
    apart = max(abs(a - b) for a, b in zip(turns[0][before]["shape"], turns[0][after]["shape"], strict=True))
    least = {label: min(turn[label]["us"] for turn in turns) for label in trees}
    table = []
    for label in trees:
        table.append(
            {
                "case": f"pool chain, {SEGMENTS} segments, {STEP_MS} ms",
                "method": label,
                "error": 1e3 * apart if label == after else 0.0,
                "error_unit": "mm, largest difference of the last shape",
                "same_bits": turns[0][label]["nodes"] == turns[0][before]["nodes"],
                "us": least[label],
                "over_before": least[label] / least[before],
                "reference": f"commit {BEFORE}",
            }
        )
    return table
