"""Bodies on a line with each of its terms on, coupled by power bonds, against line and bodies as one system.

The reference is the same line with the bodies as clump weights on its free end nodes, in finer steps and without a
bond; of a line on a winch, which takes no clumps, it is the bonded one in finer steps.
"""

# No postponed annotations: `towline bench` does not register this module, and dataclasses would look for it.
import importlib.util
import sys
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from components.contract import HEADER
from components.tether.cable import line as layout
from components.tether.cable.clumps import CLUMP
from components.tether.cable.pieces import Clump
from pipeline.conductor import Conductor
from pipeline.errors import StepError
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

SPEC = importlib.util.spec_from_file_location("bond_convergence", Path(__file__).parent / "bond_convergence.py")
assert SPEC is not None
assert SPEC.loader is not None
bond = sys.modules.get(SPEC.name) or importlib.util.module_from_spec(SPEC)
if SPEC.name not in sys.modules:
    sys.modules[SPEC.name] = bond  # dataclasses look their module up
    SPEC.loader.exec_module(bond)

REFERENCE_STEP = 2.5e-4  # s
FIRST = 1e-4  # s
STEPS = (0.0005, 0.002, 0.01, 0.02, 0.05, 0.1)  # s
RATIOS = (10.0, 0.1)
G = bond.GRAVITY
HALF = {"length": "1.75 m", "segments": 5}
TERMS: dict[str, dict[str, Any]] = {
    "plain": {},
    "bending": {"bending_stiffness": "0.05 N*m^2"},
    "seabed": {"seabed_friction": "0.5"},
    "current": {"current": ["0.3 m/s", "0.5 m/s", "0 m/s"]},
    "waves": {"waves": [{"amplitude": "0.3 m", "period": "3 s"}]},
    "sections": {
        "sections": [HALF | {"mass_per_length": "0.3 kg/m"}, HALF | {"axial_stiffness": "1e5 N"}],
        "clumps": [{"at": "1 m", "mass": "0.1 kg", "volume": "2e-5 m^3", "drag_area": "0.002 m^2"}],
    },
    "inextensible": {"axial_stiffness": None},
    "winch": {"winch": "b"},
    "cut": {},
    "break": {"breaking_load": "30 N"},
}
BED = {"anchored": 3.0, "body": 0.6}  # m
PAYOUT = 0.3  # m/s
CUT_AT, CUT = 1.0, 5  # s, segment


@dataclass(frozen=True)
class Case:
    """A line with a term on, and bodies of ratio times the plain line's mass each: on the last node, or (far) on both.

    One body is let go where the line hangs loose by 3 %, and swings; two, which bear the line's weight, start 0.9 of
    its length apart and turn about each other; in a current, in which the line hangs in balance, they start at rest.
    """

    term: str
    ratio: float
    far: str

    @property
    def mass(self) -> float:
        return self.ratio * bond.CHAIN_MASS

    @property
    def name(self) -> str:
        return f"{self.term}, M/mL={self.ratio:g}, {self.far}"

    @property
    def bodies(self) -> dict[str, Any]:
        """By the end that they are on."""
        length = bond.LENGTH
        if self.far == "anchored":
            own = (0.0, 0.0, self.mass * G)
            return {"b": bond.Body((0.5 * length, 0.1 * length, 0.83 * length), weight=own)}
        lift = (0.0, 0.0, -0.5 * bond.WET_WEIGHT)
        speed = 0.0 if self.term == "current" else 0.5
        a = bond.Body(bond.ZERO, (0.0, speed, 0.0), lift)
        return {"a": a, "b": bond.Body((0.9 * length, 0.0, 0.0), (0.0, -speed, 0.0), lift)}

    @property
    def line(self) -> dict[str, Any]:
        """The line's parameters as YAML."""
        line = bond._written(bond.CABLE, bond.CHAIN) | TERMS[self.term]
        if self.term == "seabed":
            line["seabed"] = f"{BED[self.far]} m"
        return {name: value for name, value in line.items() if value is not None}


def scenario(case: Case, h: float, rounds: int, accelerations: np.ndarray | None = None) -> str:
    """The case as YAML with steps of h [s] and at most so many rounds; accelerations: of the bodies at t0, or none."""
    components, wires, bonds = {}, {}, {}
    if accelerations is None:
        accelerations = np.zeros((len(case.bodies), 3))
    for (node, body), acceleration in zip(case.bodies.items(), accelerations, strict=True):
        values = {"mass": case.mass, **vars(body), "acceleration": tuple(acceleration)}
        components[node] = {"model": "vessel.mass", "parameters": bond._written(bond.MASS, values)}
        ends = {"body": f"{node}.hook", "line": f"line.end_{node}"}
        bonds[node] = {**ends, "rounds": rounds, "tolerance": f"{bond.TOLERANCE!r} N"}
    if case.far == "anchored":
        components["anchor"] = {"model": "motion.fixed", "parameters": {"position": ["0 m"] * 3}}
        wires["end_a"] = "anchor.motion"
    if case.term == "winch":
        limits = {"max_speed": "1 m/s", "max_acceleration": "0.5 m/s^2", "stall_tension": "1e6 N", "stored": "9 m"}
        components["drum"] = {
            "model": "winch.drum",
            "parameters": {"speed": f"{PAYOUT} m/s", **limits},
            "inputs": {"tension": {"from": "line.tension[9]", "delay": True}},
        }
        wires["payout_rate"] = "drum.payout_rate"
    components["line"] = {"model": "tether.cable", "parameters": case.line, "inputs": wires}
    happens = [{"at": f"{CUT_AT} s", "set": {"line.cut": CUT}}] if case.term == "cut" else []
    times = {"duration": f"{bond.DURATION} s", "step": f"{round(h * 1e6)} us"}
    return yaml.safe_dump({**times, "components": components, "bonds": bonds, "events": happens}, sort_keys=False)


def graph_of(case: Case, h: float, rounds: int, accelerations: np.ndarray | None = None) -> Any:
    """The case wired."""
    return build_graph(load_scenario_text(scenario(case, h, rounds, accelerations), "bond_terms", Path.cwd()))


def conducted(case: Case, h: float, rounds: int) -> np.ndarray:
    """Positions of the bodies after each step, (steps, bodies, 3), up to where the run stopped."""
    conductor = Conductor(graph_of(case, h, rounds, at_start(case)))
    rows: list[list[np.ndarray]] = [[] for _ in case.bodies]
    conductor.initialise()
    try:
        for _ in conductor.run(conductor.graph.ticks):
            for channel, values in conductor.captured():
                if channel < len(rows):
                    rows[channel].append(values[:, 1:4].copy())
    except StepError:
        pass
    return np.stack([np.concatenate(body) for body in rows], axis=1)


def whole(case: Case, h: float) -> tuple[Any, list[int]]:
    """Line and bodies as one: the line with the bodies as clumps on its end nodes, which are free; and those nodes."""
    line = next(node.parameters for node in graph_of(case, h, 1).nodes if node.name == "line")
    # A bonded line that is not to stretch is a stiff one.
    stiffness = bond.CABLE.lines["end_b"].stiffness(line) * bond.LENGTH
    apart = line.model_copy(
        update={"bond_a": False, "bond_b": False, "tolerance": 1e-9}
        | ({"axial_stiffness": stiffness} if line.axial_stiffness is None else {})
    )
    hung = bond.Instance(bond.CABLE, apart, h)
    ends = [case.bodies.get(end, bond.Body(bond.ZERO)) for end in "ab"]
    hung.u[:18] = np.concatenate([(*end.position, *end.velocity, *bond.ZERO) for end in ends])
    hung.init()
    added = tuple(Clump(at=bond.LENGTH * (end == "b"), mass=case.mass) for end in case.bodies)
    joint = bond.Instance(bond.CABLE, apart.model_copy(update={"clumps": (*line.clumps, *added)}), h)
    fields = layout.Line._fields
    table = int(joint.p[HEADER + fields.index("clumps")])
    hanging = joint.p[table + 1 : table + 1 + CLUMP * int(joint.p[table])].reshape(-1, CLUMP)
    nodes = [0 if end == "a" else bond.SEGMENTS for end in case.bodies]
    for node, (end, body) in zip(nodes, case.bodies.items(), strict=True):
        joint.p[HEADER + fields.index(f"end_{end}")] = layout.FREE
        hanging[hanging[:, 0] == node, 4] = body.weight[2]
    joint.x[:], joint.u[:] = hung.x, hung.u
    return joint, nodes


def records(line: Any) -> np.ndarray:
    """A view of the nodes' records."""
    return line.x[: layout.STATE * (bond.SEGMENTS + 1)].reshape(-1, layout.STATE)


@cache
def at_start(case: Case) -> np.ndarray:
    """Accelerations of the bodies at t0 (bodies, 3): over a first instant."""
    line, nodes = whole(replace(case, term="plain") if case.term == "winch" else case, FIRST)
    line.step()
    return records(line)[nodes, layout.ACC : layout.ACC + 3].copy()


@cache
def reference(case: Case, h: float = REFERENCE_STEP) -> np.ndarray:
    """Positions of the bodies at the multiples of GRID (k, bodies, 3), without a bond but where a winch runs."""
    every = round(bond.GRID / h)
    if case.term == "winch":
        return conducted(case, h, bond.ROUNDS + 1)[every - 1 :: every]
    line, nodes = whole(case, h)
    for motion in (layout.ACC, layout.A):
        records(line)[nodes, motion : motion + 3] = at_start(case)
    found = []
    for k in range(round(bond.DURATION / bond.GRID)):
        if case.term == "cut" and k == round(CUT_AT / bond.GRID):
            line.p[HEADER + layout.Line._fields.index("event_cut")] = CUT
        for _ in range(every):
            line.step()
        found.append(records(line)[nodes, :3].copy())
    return np.array(found)


def measure(case: Case, h: float, rounds: int = bond.ROUNDS) -> tuple[float, bool]:
    """Largest distance of a body from the reference [m], and whether the motion stayed within bounds.

    Bounds and what is beyond them as in bond_convergence.
    """
    there = reference(case)
    begin = np.array([body.position for body in case.bodies.values()])
    positions = conducted(case, h, rounds)
    travel = 3.0 * (np.abs(there - begin).max() + bond.LENGTH)
    if len(positions) < round(bond.DURATION / h) or not np.abs(positions - begin).max() <= travel:
        return float("inf"), False
    every = round(bond.GRID / h)
    return float(np.linalg.norm(positions[every - 1 :: every] - there, axis=-1).max()), True


# The load that breaks the line is one that a body of a tenth of its mass does not bring about, nor two that float.
CASES = [
    case
    for case in (Case(*c) for c in product(TERMS, RATIOS, ("anchored", "body")))
    if case.term != "break" or (case.ratio, case.far) == (10.0, "anchored")
]


def rows(cases: list[Case] | None = None, steps: tuple[float, ...] = STEPS) -> list[dict]:
    """What `towline bench bond_terms` prints: case, step [s], error (largest over 2 s), whether it is stable."""
    table = []
    for case, h in product(cases or CASES, steps):
        error, stable = measure(case, h)
        table.append({"case": case.name, "step": h, "error": error, "error_unit": "m", "stable": stable})
    return table
