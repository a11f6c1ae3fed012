"""Bodies on a line, coupled in four ways, against the same discrete line with the bodies' masses on its end nodes.

One body is on the last node, with the first one anchored or free; or two equal ones are on both. The conductor steps
them as it steps any scenario. The reference knows nothing of the components but the line's shape at t0: forces written
anew, classical Runge-Kutta at 50 microseconds.
"""

# No postponed annotations: `towline bench` does not register this module, and dataclasses would look for it.
from dataclasses import dataclass
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
import yaml
from numba import njit

from components.compiled import functions
from components.constants import GRAVITY
from components.contract import Component, Parameters
from components.tether.cable.component import COMPONENT as CABLE
from components.tether.cable.line import STATE, Q, V
from components.vessel.mass.component import COMPONENT as MASS
from pipeline.conductor import Conductor
from pipeline.errors import StepError
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

LENGTH, SEGMENTS = 3.5, 10
# The pool chain of Drupt et al. 2022, Table I: 0.092 kg/m wet, dry by steel's 7850 kg/m^3; 10 mm wide links. EA as for
# a studless chain: DNV's EA = 0.854e8 d^2 kN and mass = 19.9e3 d^2 kg/m give 4.29e6 N per kg/m, so here 4.5e5 N.
CHAIN = {
    "length": LENGTH,
    "segments": SEGMENTS,
    "mass_per_length": 0.1054,
    "volume_per_length": 0.1054 / 7850,
    "drag_diameter": 0.01,
    "axial_stiffness": 4.5e5,
    "fluid_density": 1000.0,
    "gravity": GRAVITY,
    "sub_steps": 1,  # as a bonded line takes, so that the methods differ by the coupling alone
}
VACUUM = {"fluid_density": 0.0, "gravity": 0.0}
CHAIN_MASS = CHAIN["mass_per_length"] * LENGTH
WET_WEIGHT = (CHAIN["mass_per_length"] - CHAIN["fluid_density"] * CHAIN["volume_per_length"]) * GRAVITY * LENGTH
DURATION = 2.0  # s
REFERENCE_STEP = 5e-5  # s
GRID = 0.1  # s, where positions are compared: a multiple of every step
STEPS = (0.0005, 0.002, 0.01, 0.02, 0.05, 0.1)  # s
PAIR_STEPS = (0.005, 0.01, 0.02, 0.05)  # s
RATIOS = (100.0, 10.0, 1.0, 0.1)
ROUNDS, TOLERANCE = 8, 1e-6  # N
ZERO = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Body:
    """What `vessel.mass` takes beside its mass; velocity and acceleration are those at t0."""

    position: tuple[float, ...]
    velocity: tuple[float, ...] = ZERO
    weight: tuple[float, ...] = ZERO
    stiffness: tuple[float, ...] = ZERO
    rest: tuple[float, ...] = ZERO


@dataclass(frozen=True)
class Case:
    """Bodies of ratio times the line's mass each: one on the last node, or two with far = "body".

    far: "anchored", "free" or "body", what the first node is. motion of one body: "hanging", pushed aside from balance,
    or "swinging", let go far from it; of two: "towed", pulled taut and pushed aside in water, or "spinning" in vacuum.
    """

    ratio: float
    far: str
    motion: str

    @property
    def mass(self) -> float:
        return self.ratio * CHAIN_MASS

    @property
    def name(self) -> str:
        return f"M/mL={self.ratio:g} {self.far} {self.motion}"

    @property
    def nodes(self) -> tuple[str, ...]:
        """The ends that the bodies are on."""
        return ("a", "b")[-len(self.bodies) :]

    @property
    def line(self) -> dict[str, float]:
        return CHAIN | (VACUUM if self.motion == "spinning" else {})

    @property
    def bodies(self) -> tuple[Body, ...]:
        """From the first node to the last."""
        if self.far == "body":
            return self._spinning() if self.motion == "spinning" else self._towed()
        return (self._on_springs(),) if self.far == "free" else (self._hanging(),)

    def _hanging(self) -> Body:
        own = self.mass * GRAVITY
        stretched = LENGTH * (1.0 + (own + 0.5 * WET_WEIGHT) / CHAIN["axial_stiffness"])
        start = (0.0, 0.0, stretched) if self.motion == "hanging" else (0.5 * LENGTH, 0.1 * LENGTH, 0.83 * LENGTH)
        push = 0.1 * own if self.motion == "hanging" else 0.0
        return Body(start, weight=(push, 0.3 * push, own))

    def _on_springs(self) -> Body:
        own = self.mass * GRAVITY
        stiffness = 9.0 * (self.mass + CHAIN_MASS)
        push, aside = (0.5 * stiffness / 9.0, 0.0) if self.motion == "hanging" else (0.0, 0.5)
        rest = (-aside, 0.0, -(own + WET_WEIGHT) / stiffness)
        return Body(ZERO, weight=(push, 0.3 * push, own), stiffness=(stiffness,) * 3, rest=rest)

    def _spinning(self) -> tuple[Body, Body]:
        return Body(ZERO, (0.0, 1.0, 0.3)), Body((LENGTH, 0.0, 0.0), (0.0, -0.5, 0.0))

    def _towed(self) -> tuple[Body, Body]:
        """Ends 0.2 % nearer than the line is long, held by its own pull; the second is pushed aside by half of that."""
        apart = (0.998 * LENGTH, 0.0, 0.0)
        line = hang(self.line, Body(ZERO), Body(apart))
        a, b = line.bundle("force_a"), line.bundle("force_b")
        return Body(ZERO, weight=tuple(-a)), Body(apart, weight=tuple(-b + (0.0, 0.5 * np.linalg.norm(b), 0.0)))


SINGLE = [Case(*c) for c in product(RATIOS, ("anchored", "free"), ("hanging", "swinging"))]
PAIRS = [Case(ratio, "body", motion) for ratio, motion in product(RATIOS, ("towed", "spinning"))]


class Instance:
    """One component outside a conductor: its vectors and its compiled functions."""

    def __init__(self, component: Component, parameters: Parameters, h: float):
        self.p = component.pack(parameters)
        _, n_u, n_x, n_y, n_w = (int(n) for n in self.p[:5])
        self.u, self.x, self.y, self.w = np.zeros(n_u), np.zeros(n_x), np.zeros(n_y), np.zeros(n_w)
        self.h, self.t, self.functions = round(h * 1e9), 0, _functions(component.name)
        self.slices, k = {}, 0
        for port in component.outputs(parameters):
            self.slices[port.name] = slice(k, k + port.size)
            k += port.size

    def init(self) -> None:
        self._call(0)

    def step(self) -> None:
        self.t += self.h
        self._call(1)

    def _call(self, which: int) -> None:
        status = self.functions[which](self.t, self.h, self.p, self.u, self.x, self.y, self.w)
        if status != 0:
            raise FloatingPointError(f"status {status} at {self.t / 1e9} s")

    def bundle(self, name: str) -> np.ndarray:
        """A bundle of outputs, in the order of its ports."""
        parts = [s for port, s in self.slices.items() if port.split(".")[0] == name]
        return self.y[parts[0].start : parts[-1].stop]


@cache
def _functions(name: str) -> tuple:
    return functions({CABLE.name: CABLE, MASS.name: MASS}[name])


def hang(line: dict[str, float], a: Body | None, b: Body, h: float = GRID) -> Instance:
    """The line at t0, not bonded, between two bodies' positions and moving with them; a None: its first end is free."""
    cable = Instance(CABLE, CABLE.parameters(**line, end_a="driven" if a else "free"), h)
    cable.u[:] = np.concatenate([(*end.position, *end.velocity, *ZERO) for end in (a, b) if end])
    cable.init()
    return cable


def start(case: Case, h: float = GRID) -> Instance:
    """The case's line at t0."""
    first = {"anchored": Body(ZERO), "free": None, "body": case.bodies[0]}[case.far]
    return hang(case.line, first, case.bodies[-1], h)


def _written(component: Component, values: dict) -> dict:
    """Parameters as YAML takes them, with the units that the component declares."""
    units = {name: field.json_schema_extra["unit"] for name, field in component.parameters.model_fields.items()}

    def one(value: float, unit: str) -> float | str:
        return value if unit in (None, "1") else f"{float(value)!r} {unit}"

    return {
        name: [one(v, units[name]) for v in value] if isinstance(value, tuple) else one(value, units[name])
        for name, value in values.items()
    }


def scenario(case: Case, h: float, rounds: int) -> str:
    """The case as YAML with steps of h [s]; rounds: at most so many on its bonds, 0 for plainly delayed forces."""
    components, wires, bonds = {}, {}, {}
    for node, body, acceleration in zip(case.nodes, case.bodies, monolith(case).accelerations, strict=True):
        values = {"mass": case.mass, **vars(body), "acceleration": tuple(acceleration)}
        components[node] = {"model": "vessel.mass", "parameters": _written(MASS, values)}
        if rounds:
            ends = {"body": f"{node}.hook", "line": f"line.end_{node}"}
            bonds[node] = {**ends, "rounds": rounds, "tolerance": f"{TOLERANCE!r} N"}
        else:
            components[node]["parameters"]["takes_force"] = True
            components[node]["inputs"] = {"force": {"from": f"line.force_{node}", "delay": True}}
            wires[f"end_{node}"] = f"{node}.hook"
    if case.far == "anchored":
        components["anchor"] = {"model": "motion.fixed", "parameters": {"position": ["0 m"] * 3}}
        wires["end_a"] = "anchor.motion"
    line = {**_written(CABLE, case.line), "end_a": "free" if case.far == "free" else "driven"}
    components["line"] = {"model": "tether.cable", "parameters": line, "inputs": wires}
    times = {"duration": f"{DURATION} s", "step": f"{round(h * 1e6)} us"}
    return yaml.safe_dump({**times, "components": components, "bonds": bonds}, sort_keys=False)


def conducted(case: Case, h: float, rounds: int) -> np.ndarray:
    """Positions of the bodies after each step, (steps, bodies, 3), up to where the run stopped."""
    graph = build_graph(load_scenario_text(scenario(case, h, rounds), "bond_convergence", Path.cwd()))
    conductor, rows = Conductor(graph), [[] for _ in case.bodies]
    conductor.initialise()
    try:
        for _ in conductor.run(graph.ticks):
            for channel, values in conductor.captured():
                if channel < len(rows):
                    rows[channel].append(values[:, 1:4].copy())
    except StepError:
        pass
    return np.stack([np.concatenate(body) for body in rows], axis=1)


def held(case: Case, h: float, parts: int = 4) -> np.ndarray:
    """As `conducted` with plainly delayed forces, but the line's last end moves at constant velocity over each step.

    The line takes the step in parts. Single bodies only.
    """
    own = {"mass": case.mass, **vars(case.bodies[0]), "acceleration": tuple(monolith(case).accelerations[0])}
    body = Instance(MASS, MASS.parameters(**own, takes_force=True), h)
    body.init()
    line, positions = start(case, h / parts), []
    try:
        for _ in range(round(DURATION / h)):
            before = body.y[:3].copy()
            body.u[:] = line.bundle("force_b")
            body.step()
            velocity = (body.y[:3] - before) / h
            for k in range(1, parts + 1):
                line.u[-9:] = np.concatenate([before + velocity * h * k / parts, velocity, np.zeros(3)])
                line.step()
            positions.append(body.y[:3].copy())
    except FloatingPointError:
        pass
    return np.reshape(positions, (-1, 1, 3))


@njit(error_model="numpy")
def _solved(m, f, acc):
    """acc = m^-1 f of a 3x3 matrix, by Cramer's rule."""
    for c in range(3):
        i, j = (c + 1) % 3, (c + 2) % 3
        acc[c] = f[0] * (m[1, i] * m[2, j] - m[1, j] * m[2, i])
        acc[c] -= f[1] * (m[0, i] * m[2, j] - m[0, j] * m[2, i])
        acc[c] += f[2] * (m[0, i] * m[1, j] - m[0, j] * m[1, i])
    acc /= (
        m[0, 0] * (m[1, 1] * m[2, 2] - m[1, 2] * m[2, 1])
        - m[0, 1] * (m[1, 0] * m[2, 2] - m[1, 2] * m[2, 0])
        + m[0, 2] * (m[1, 0] * m[2, 1] - m[1, 1] * m[2, 0])
    )


@njit(error_model="numpy")
def _accelerations(q, v, free, density, gravity, mass, weight, stiffness, rest):
    """Accelerations (n+1, 3) of the nodes from `free` on: each node's forces over its own 3x3 mass.

    mass (2,), weight, stiffness, rest (2, 3): of the bodies on the first and the last node.
    """
    n = len(q) - 1
    l0, own, displaced = LENGTH / n, 0.1054, density * 0.1054 / 7850
    f, m, acc = np.zeros((n + 1, 3)), np.zeros((n + 1, 3, 3)), np.zeros((n + 1, 3))
    t, across = np.zeros(3), np.zeros(3)
    for j in range(n):
        t[:] = q[j + 1] - q[j]
        length = np.sqrt(t[0] ** 2 + t[1] ** 2 + t[2] ** 2)
        t /= length
        tension = max(0.0, 4.5e5 * (length / l0 - 1.0))
        for i, sign in ((j, 1.0), (j + 1, -1.0)):
            along = v[i, 0] * t[0] + v[i, 1] * t[1] + v[i, 2] * t[2]
            for c in range(3):
                across[c] = v[i, c] - along * t[c]
            speed = np.sqrt(across[0] ** 2 + across[1] ** 2 + across[2] ** 2)
            for c in range(3):
                f[i, c] += sign * tension * t[c] - 0.5 * density * 0.01 * 1.2 * 0.5 * l0 * speed * across[c]
                m[i, c, c] += 0.5 * l0 * (own + displaced)
                for d in range(3):
                    m[i, c, d] -= 0.5 * l0 * displaced * t[c] * t[d]
            f[i, 2] += 0.5 * l0 * (own - displaced) * gravity
    for i, end in ((0, 0), (n, 1)):
        for c in range(3):
            f[i, c] += weight[end, c] - stiffness[end, c] * (q[i, c] - rest[end, c])
            m[i, c, c] += mass[end]
    for i in range(free, n + 1):
        _solved(m[i], f[i], acc[i])
    return acc


@njit(error_model="numpy")
def _runge_kutta(q, v, h, steps, every, system):
    """Positions of the first and the last node after each `every` steps of the classical method."""
    kept = np.zeros((steps // every, 2, 3))
    for k in range(steps):
        a1 = _accelerations(q, v, *system)
        v2 = v + 0.5 * h * a1
        a2 = _accelerations(q + 0.5 * h * v, v2, *system)
        v3 = v + 0.5 * h * a2
        a3 = _accelerations(q + 0.5 * h * v2, v3, *system)
        v4 = v + h * a3
        a4 = _accelerations(q + h * v3, v4, *system)
        q = q + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
        v = v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        if (k + 1) % every == 0:
            kept[(k + 1) // every - 1, 0] = q[0]
            kept[(k + 1) // every - 1, 1] = q[-1]
    return kept


@dataclass(frozen=True)
class Monolith:
    """The reference: accelerations at t0 (bodies, 3), and positions at the multiples of GRID (k, bodies, 3)."""

    accelerations: np.ndarray
    positions: np.ndarray


@cache
def monolith(case: Case, h: float = REFERENCE_STEP) -> Monolith:
    """Line and bodies as one system, from the line's own equilibrium at t0."""
    nodes = start(case).x[: STATE * (SEGMENTS + 1)].reshape(-1, STATE)
    q, v = nodes[:, Q : Q + 3].copy(), nodes[:, V : V + 3].copy()
    mass, vectors = np.zeros(2), np.zeros((3, 2, 3))
    for end, body in enumerate(case.bodies, 2 - len(case.bodies)):
        mass[end] = case.mass
        vectors[:, end] = body.weight, body.stiffness, body.rest
    line = case.line
    system = (1 if case.far == "anchored" else 0, line["fluid_density"], line["gravity"], mass, *vectors)
    ends = [0, -1][2 - len(case.bodies) :]
    accelerations = _accelerations(q, v, *system)[ends]
    positions = _runge_kutta(q, v, h, round(DURATION / h), round(GRID / h), system)
    return Monolith(accelerations, positions[:, ends])


METHODS = {
    "one round": lambda case, h: conducted(case, h, 1),
    "re-linearised rounds": lambda case, h: conducted(case, h, ROUNDS),
    "held velocity": held,
    "plainly delayed force": lambda case, h: conducted(case, h, 0),
}


def methods(case: Case) -> list[str]:
    """What the case is measured with."""
    return [name for name in METHODS if case.far != "body" or name != "held velocity"]


def measure(case: Case, method: str, h: float) -> tuple[float, bool]:
    """Largest distance of a body from the reference on the grid [m], and whether the motion stayed within bounds.

    Bounds: three times the reference's own travel and the line's length; infinite error beyond, or where a run stops.
    """
    reference = monolith(case).positions
    begin = np.array([body.position for body in case.bodies])
    positions = METHODS[method](case, h)
    travel = 3.0 * (np.abs(reference - begin).max() + LENGTH)
    if len(positions) < round(DURATION / h) or not np.abs(positions - begin).max() <= travel:
        return float("inf"), False
    every = round(GRID / h)
    return float(np.linalg.norm(positions[every - 1 :: every] - reference, axis=-1).max()), True


def rows(cases: list[Case] | None = None, steps: tuple[float, ...] | None = None) -> list[dict]:
    """What `towline bench bond_convergence` prints: case, method, step [s], error (largest over 2 s), stable."""
    table = []
    for case in cases or SINGLE + PAIRS:
        for h, method in product(steps or (PAIR_STEPS if case.far == "body" else STEPS), methods(case)):
            error, stable = measure(case, method, h)
            table.append(
                {"case": case.name, "method": method, "step": h, "error": error, "error_unit": "m", "stable": stable}
            )
    return table
