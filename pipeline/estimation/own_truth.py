"""A filter beside a truth that its own model makes with the noise that it assumes, by which consistency is judged."""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot

import numpy as np

from components.contract import Component
from components.estimator.best.model import Best
from components.estimator.line import Line
from components.estimator.modal import joints
from pipeline.estimation.stepping import Stepper


@dataclass(frozen=True)
class Campaign:
    """Of each run and step (runs, steps): see the outputs of the estimators; innovations: (runs, steps, k)."""

    nis: np.ndarray
    freedom: np.ndarray
    nees: np.ndarray
    innovations: np.ndarray
    tension: np.ndarray
    true_tension: np.ndarray
    states: int


class Twin:
    """A filter whose first state is right but for what it says it may be off by, and the truth."""

    def __init__(self, component: Component, parameters: Line, h: float, seed: int, missing: float = 0.0):
        """missing: share of the markers that are not seen. The parameters must give the first angles."""
        self.random = np.random.default_rng(seed)
        self.filter = Stepper(component, parameters, h)
        self.line, self.missing = parameters, missing
        blind = self.filter.begin(np.zeros_like(self.filter.u))
        self.truth = blind.state + blind.root @ self.random.standard_normal(blind.states)
        self.filter.begin(self.inputs())

    @property
    def angles(self) -> np.ndarray:
        """(n,) true angles of the bars."""
        n = self.line.bars
        if isinstance(self.line, Best):
            return self.truth[:n]
        return joints(n) @ self.filter.model.modes @ self.truth[: 2 * n : 2]

    @property
    def tension(self) -> float:
        """True tension at the end; NaN where the model's forces do not tell it."""
        n = self.line.bars
        return float(np.hypot(*self.truth[2 * n : 2 * n + 2])) if isinstance(self.line, Best) else np.nan

    def at(self, places: np.ndarray) -> np.ndarray:
        """(k, 2) north and down of places along the line [m]."""
        n, l = self.line.bars, self.line.bar
        pivot = np.array(self.line.position)[[0, 2]]
        if isinstance(self.line, Best) and self.line.pivot == "moving":
            pivot = self.truth[self.filter.layout.place :][:2]
        t = np.column_stack([np.cos(self.angles), np.sin(self.angles)])
        joints_at = np.vstack([pivot, pivot + np.cumsum(l * t, axis=0)])
        bar = np.minimum((places / l + 1e-9).astype(int), n - 1)
        return joints_at[bar] + (places - bar * l)[:, None] * t[bar]

    def inputs(self) -> np.ndarray:
        """What the sensors say of the truth now."""
        line, noise = self.line, self.random.standard_normal
        m = line.markers
        seen = self.random.random(m) >= self.missing
        position = np.zeros((m, 3))
        position[:, [0, 2]] = self.at(line.places()) + hypot(line.marker_noise, line.chain_noise) * noise((m, 2))
        parts = [(position * seen[:, None]).ravel(), seen]
        if line.takes_covariance:
            parts.append(np.tile(line.marker_noise**2 * np.eye(2).ravel(), m))
        if isinstance(line, Best):
            if line.end_position_noise is not None:
                north, down = self.at(np.array([line.length]))[0] + line.end_position_noise * noise(2)
                parts.append([north, 0.0, down, 1.0])
            if line.end_tension_noise is not None:
                parts.append([self.tension + line.end_tension_noise * noise(), 1.0])
            if line.tilts:
                bars = np.minimum((np.array(line.tilts) / line.bar).astype(int), line.bars - 1)
                parts += [self.angles[bars] + line.tilt_noise * noise(len(bars)), np.ones(len(bars))]
            if line.gyros:
                bars = np.minimum((np.array(line.gyros) / line.bar).astype(int), line.bars - 1)
                rates = self.truth[line.bars + bars]
                parts += [rates + line.gyro_noise * noise(len(bars)), np.ones(len(bars))]
        return np.concatenate([np.asarray(part, np.float64) for part in parts])

    def move(self) -> np.ndarray:
        """Move the truth on; what the sensors then say."""
        fresh, _, noise = self.filter.moved(self.truth)
        self.truth = fresh + noise @ self.random.standard_normal(noise.shape[1])
        return self.inputs()

    def step(self) -> None:
        """Move the truth on, and the filter with what is then seen."""
        self.filter.step(self.move())


def campaign(component: Component, parameters: Line, h: float, runs: int, steps: int, missing: float = 0.0) -> Campaign:
    """Runs of seeds 0, 1, ... of a filter beside its own truth."""
    rows: dict[str, list] = {name: [] for name in Campaign.__dataclass_fields__ if name != "states"}
    for seed in range(runs):
        twin = Twin(component, parameters, h, seed, missing)
        run: dict[str, list] = {name: [] for name in rows}
        for _ in range(steps):
            twin.step()
            f = twin.filter
            error = np.linalg.solve(f.root, f.state - twin.truth)
            run["nis"].append(f["nis"].item())
            run["freedom"].append(f["freedom"].item())
            run["nees"].append(error @ error)
            run["innovations"].append(f["innovation"])
            run["tension"].append(f["end_tension"].item())
            run["true_tension"].append(twin.tension)
        for name, values in run.items():
            rows[name].append(values)
    return Campaign(**{name: np.array(values) for name, values in rows.items()}, states=twin.filter.states)
