"""A body on a line, coupled in four ways, against the same discrete line with the body's mass on its end node.

The reference knows nothing of the components but the line's shape at t0: forces written anew, classical Runge-Kutta
at 50 microseconds.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np
from numba import njit

from components.compiled import as_compiled
from components.contract import Component, Parameters
from components.tether.cable.component import COMPONENT as CABLE
from components.vessel.mass.component import COMPONENT as MASS

LENGTH, SEGMENTS, G = 3.5, 10, 9.80665
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
    "gravity": G,
}
DURATION = 2.0  # s
REFERENCE_STEP = 5e-5  # s
GRID = 0.1  # s, where positions are compared: a multiple of every step
STEPS = (0.0005, 0.002, 0.01, 0.02, 0.05, 0.1)  # s
RATIOS = (100.0, 10.0, 1.0, 0.1)
ROUNDS, TOLERANCE = 8, 1e-6  # N


@dataclass(frozen=True)
class Case:
    """A body of ratio times the line's mass on its last node; the first node is anchored or free."""

    ratio: float
    far: str  # "anchored" or "free"
    motion: str  # "hanging": pushed aside from balance; "swinging": let go far from it

    @property
    def mass(self) -> float:
        return self.ratio * CHAIN["mass_per_length"] * LENGTH

    @property
    def name(self) -> str:
        return f"M/mL={self.ratio:g} {self.far} {self.motion}"

    def body(self) -> dict[str, tuple[float, float, float]]:
        """Weight, springs, rest position and position of the body."""
        own = self.mass * G
        wet = (CHAIN["mass_per_length"] - CHAIN["fluid_density"] * CHAIN["volume_per_length"]) * G * LENGTH
        if self.far == "free":
            stiffness = 9.0 * (self.mass + CHAIN["mass_per_length"] * LENGTH)
            push, aside = (0.5 * stiffness / 9.0, 0.0) if self.motion == "hanging" else (0.0, 0.5)
            rest = (-aside, 0.0, -(own + wet) / stiffness)
            return {
                "weight": (push, 0.3 * push, own),
                "stiffness": (stiffness,) * 3,
                "rest": rest,
                "position": (0, 0, 0),
            }
        stretched = LENGTH * (1.0 + (own + 0.5 * wet) / CHAIN["axial_stiffness"])
        start = (0.0, 0.0, stretched) if self.motion == "hanging" else (0.5 * LENGTH, 0.1 * LENGTH, 0.83 * LENGTH)
        push = 0.1 * own if self.motion == "hanging" else 0.0
        return {"weight": (push, 0.3 * push, own), "stiffness": (0, 0, 0), "rest": (0, 0, 0), "position": start}


CASES = [Case(*c) for c in product(RATIOS, ("anchored", "free"), ("hanging", "swinging"))]


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
    component = {CABLE.name: CABLE, MASS.name: MASS}[name]
    return as_compiled(component.init), as_compiled(component.step)


def _pair(case: Case, h: float, bonded: bool, acceleration: np.ndarray) -> tuple[Instance, Instance]:
    """Body and line, initialised in the order of the direct wire hook -> end_b."""
    body = MASS.parameters(
        mass=case.mass, **case.body(), acceleration=tuple(acceleration), takes_law=bonded, takes_force=not bonded
    )
    line = CABLE.parameters(**CHAIN, end_a="driven" if case.far == "anchored" else "free", bond_b=bonded)
    b, c = Instance(MASS, body, h), Instance(CABLE, line, h)
    b.init()
    c.u[-9:] = b.y
    c.init()
    return b, c


def bond(case: Case, h: float, rounds: int) -> Iterator[np.ndarray]:
    """Positions of the body after each step with the affine law, repeated about the accepted motion up to `rounds`."""
    body, line = _pair(case, h, True, monolith(case).acceleration)
    while True:
        saved = body.x.copy(), line.x.copy()
        law = line.bundle("law_b").copy()
        for k in range(rounds):
            if k:
                body.x[:], line.x[:] = saved
                body.t, line.t = body.t - body.h, line.t - line.h
            body.u[:] = law
            body.step()
            line.u[-9:] = body.y
            line.step()
            accepted = line.bundle("accepted_b")
            expected = law[:3] - law[6:].reshape(3, 3) @ (body.bundle("hook")[6:] - law[3:6])
            if np.abs(accepted[:3] - expected).max() <= TOLERANCE:
                break
            law = accepted.copy()
        yield body.y[:3].copy()


def delayed(case: Case, h: float) -> Iterator[np.ndarray]:
    """Positions of the body when it takes the force of the step before, the line following its motion exactly."""
    body, line = _pair(case, h, False, monolith(case).acceleration)
    while True:
        body.u[:] = line.bundle("force_b")
        body.step()
        line.u[-9:] = body.y
        line.step()
        yield body.y[:3].copy()


def held(case: Case, h: float, parts: int = 4) -> Iterator[np.ndarray]:
    """As `delayed`, but the line's end moves at constant velocity over the step, which the line takes in parts."""
    body, _ = _pair(case, h, False, monolith(case).acceleration)
    _, line = _pair(case, h / parts, False, np.zeros(3))
    while True:
        before = body.y[:3].copy()
        body.u[:] = line.bundle("force_b")
        body.step()
        velocity = (body.y[:3] - before) / h
        for k in range(1, parts + 1):
            line.u[-9:] = np.concatenate([before + velocity * h * k / parts, velocity, np.zeros(3)])
            line.step()
        yield body.y[:3].copy()


@njit(error_model="numpy")
def _accelerations(q, v, first, body, weight, stiffness, rest):
    """Accelerations (n+1, 3) of the nodes from `first` on: each node's forces over its own 3x3 mass."""
    n = len(q) - 1
    l0, mass, displaced = LENGTH / n, 0.1054, 1000.0 * 0.1054 / 7850
    f, m, acc = np.zeros((n + 1, 3)), np.zeros((n + 1, 3, 3)), np.zeros((n + 1, 3))
    for j in range(n):
        e = q[j + 1] - q[j]
        length = np.sqrt(np.sum(e * e))
        t = e / length
        tension = max(0.0, 4.5e5 * (length / l0 - 1.0))
        f[j] += tension * t
        f[j + 1] -= tension * t
        for i in (j, j + 1):
            across = v[i] - np.sum(v[i] * t) * t
            f[i] -= 0.5 * 1000.0 * 0.01 * 1.2 * 0.5 * l0 * np.sqrt(np.sum(across * across)) * across
            f[i, 2] += 0.5 * l0 * (mass - displaced) * G
            for c in range(3):
                m[i, c] -= 0.5 * l0 * displaced * t[c] * t
                m[i, c, c] += 0.5 * l0 * (mass + displaced)
    f[n] += weight - stiffness * (q[n] - rest)
    for c in range(3):
        m[n, c, c] += body
    for i in range(first, n + 1):
        det = np.sum(m[i, 0] * np.cross(m[i, 1], m[i, 2]))
        acc[i, 0] = np.sum(f[i] * np.cross(m[i, 1], m[i, 2])) / det
        acc[i, 1] = np.sum(f[i] * np.cross(m[i, 2], m[i, 0])) / det
        acc[i, 2] = np.sum(f[i] * np.cross(m[i, 0], m[i, 1])) / det
    return acc


@njit(error_model="numpy")
def _runge_kutta(q, v, h, steps, every, first, body, weight, stiffness, rest):
    """Position of the last node after each `every` steps of the classical method."""
    kept = np.zeros((steps // every, 3))
    for k in range(steps):
        a1 = _accelerations(q, v, first, body, weight, stiffness, rest)
        v2 = v + 0.5 * h * a1
        a2 = _accelerations(q + 0.5 * h * v, v2, first, body, weight, stiffness, rest)
        v3 = v + 0.5 * h * a2
        a3 = _accelerations(q + 0.5 * h * v2, v3, first, body, weight, stiffness, rest)
        v4 = v + h * a3
        a4 = _accelerations(q + h * v3, v4, first, body, weight, stiffness, rest)
        q = q + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
        v = v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        if (k + 1) % every == 0:
            kept[(k + 1) // every - 1] = q[-1]
    return kept


@dataclass(frozen=True)
class Monolith:
    """The reference: the body's acceleration at t0 (3,) and its positions at the multiples of GRID."""

    acceleration: np.ndarray
    positions: np.ndarray


@cache
def monolith(case: Case, h: float = REFERENCE_STEP) -> Monolith:
    """Line and body as one system, from the line's own equilibrium at t0."""
    anchored = case.far == "anchored"
    body = case.body()
    line = Instance(CABLE, CABLE.parameters(**CHAIN, end_a="driven" if anchored else "free"), GRID)
    line.u[-9:-6] = body["position"]
    line.init()
    q = line.bundle("nodes").reshape(-1, 3).copy()
    weight, stiffness, rest = (np.array(body[k], float) for k in ("weight", "stiffness", "rest"))
    system = (1 if anchored else 0, case.mass, weight, stiffness, rest)
    acceleration = _accelerations(q, np.zeros_like(q), *system)[-1]
    positions = _runge_kutta(q, np.zeros_like(q), h, round(DURATION / h), round(GRID / h), *system)
    return Monolith(acceleration, positions)


METHODS = {
    "one round": lambda case, h: bond(case, h, 1),
    "re-linearised rounds": lambda case, h: bond(case, h, ROUNDS),
    "held velocity": held,
    "plainly delayed force": delayed,
}


def measure(case: Case, method: str, h: float) -> tuple[float, bool]:
    """Largest distance from the reference on the grid [m], and whether the motion stayed within bounds.

    Bounds: three times the reference's own travel and the line's length; a run that ends non-finite has infinite error.
    """
    reference = monolith(case).positions
    every, start = round(GRID / h), np.array(case.body()["position"])
    travel = 3.0 * (np.abs(reference - start).max() + LENGTH)
    motion, worst = METHODS[method](case, h), 0.0
    try:
        for k in range(1, round(DURATION / h) + 1):
            position = next(motion)
            if not np.abs(position - start).max() <= travel:
                return float("inf"), False
            if k % every == 0:
                worst = max(worst, float(np.linalg.norm(position - reference[k // every - 1])))
    except FloatingPointError:
        return float("inf"), False
    return worst, True


def rows(cases: list[Case] = CASES, steps: tuple[float, ...] = STEPS) -> list[dict]:
    """What `towline bench bond` prints: case, method, step [s], error (largest over 2 s), error_unit, stable."""
    table = []
    for case, h, method in product(cases, steps, METHODS):
        error, stable = measure(case, method, h)
        table.append(
            {"case": case.name, "method": method, "step": h, "error": error, "error_unit": "m", "stable": stable}
        )
    return table
