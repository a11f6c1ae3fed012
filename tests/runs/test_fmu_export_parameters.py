"""What an exported FMU lets be set, against Parameters.vector(): the same bits, or fixed when it was built."""

from __future__ import annotations

import ctypes
import math
from pathlib import Path
from typing import Annotated

import fmpy
import numpy as np
import pytest
from fmpy.fmi3 import FMU3Slave
from pydantic import Field, model_validator

from components.compiled import bind
from components.contract import HEADER, Component, Parameters, Port, choice, quantity
from pipeline.fmu.formulas import formulas
from pipeline.fmu.traced import evaluate
from pipeline.fmu.variables import contents, elements
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph

ROOT = Path(__file__).parents[2]
C_FUNCTION = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * 5)


class Tricky(Parameters):
    """One parameter for each way in which a number may come into p."""

    plain: float = quantity("m", "as it is", 2.0, gt=0)
    chained: float = quantity("N", "by arithmetic with numpy's numbers too", 3.0)
    pair: tuple[float, Annotated[float, Field(ge=0)]] = quantity("m", "a flat tuple", (1.0, 0.0), tunable=True)
    compared: float = quantity("m", "decides something", 4.0)
    decisive: float = quantity("m", "decides something with its bits alone", 5.0)
    rooted: float = quantity("m", "through a function that forgets", 6.0)
    sized: float = quantity("m", "decides a shape", 7.0)
    checked: float = quantity("m", "looked at by a validator", 8.0)
    none: float | None = quantity("m", "not given", None)
    unused: float = quantity("m", "of no effect", 9.0, le=10.0)
    matrix: tuple[tuple[float, ...], ...] = quantity("kg", "rows of numbers", ((1.0, 2.0), (3.0, 4.0)))
    count: int = choice("a number of things", 3)

    @model_validator(mode="after")
    def _check(self):
        if self._half() > 100.0:
            raise ValueError("too much")
        return self

    def _half(self) -> float:
        return self.checked / 2.0

    def vector(self) -> np.ndarray:
        sign = 1.0 if self.compared > 0.0 else -1.0
        hidden = 1.0 if math.floor(self.decisive) > 4 else -1.0
        chained = np.float64(0.1) * -abs(self.chained) / (self.count + self.plain) - 1
        numbers = [self.plain, chained, *self.pair, sign * self.compared, hidden, math.sqrt(self.rooted)]
        return np.array([*numbers, self.sized, self.checked, 1.0 - self.pair[1], float(self.none is None)])


def step(t_ns, dt_ns, p, u, x, y, w):
    y[0] = p[HEADER]
    return 0


TRICKY = Component(
    name="tricky",
    parameters=Tricky,
    outputs=lambda tricky: (Port("v", "m", (int(tricky.sized),)),),
    init=step,
    step=step,
)


def test_only_what_arithmetic_explains_can_be_set():
    found = formulas(TRICKY, Tricky())
    names = list(dict.fromkeys(one.name for one in found.settable))
    assert names == ["plain", "chained", "pair", "unused"]
    bounds = {(one.name, one.index): one.bounds for one in found.settable}
    assert (bounds["plain", None].low, bounds["plain", None].low_is_open) == (0.0, True)
    assert (bounds["pair", 1].low, bounds["pair", 1].low_is_open) == (0.0, False)
    assert bounds["pair", 0].low == -math.inf
    assert bounds["unused", None].high == 10.0


def test_what_cannot_be_set_is_a_constant():
    shown = {one.name: one for one in contents(TRICKY, Tricky(), 0).variables}
    assert shown["parameters.compared"].role == "constant"
    assert shown["parameters.count"].type == "integer"
    assert (shown["parameters.matrix"].shape, shown["parameters.matrix"].start) == ((2, 2), (1.0, 2.0, 3.0, 4.0))
    assert shown["parameters.pair"].tunable
    assert "parameters.none" not in shown
    assert "parameters.seed" not in shown  # step draws no random numbers
    names = [one.name for one in elements(tuple(shown.values()))]
    assert names[:3] == ["v[1]", "v[2]", "v[3]"]


@pytest.mark.parametrize("scene", ["pool_chain", "bond_mass", "van_der_pol"])
def test_formulas_give_the_bits_of_vector(scene):
    """With values far from those given, all at once."""
    draw = np.random.default_rng(3)
    for node in build_graph(load_scenario(ROOT / "scenarios" / f"{scene}.yaml")).nodes:
        found = formulas(node.component, node.parameters)
        q = [one.value * draw.uniform(0.01, 100.0) + draw.uniform(0.0, 1e-3) for one in found.settable]
        changed = dict(node.parameters)
        for one, value in zip(found.settable, q, strict=True):
            old = changed[one.name]
            changed[one.name] = value if one.index is None else (*old[: one.index], value, *old[one.index + 1 :])
        expected = node.component.pack(type(node.parameters).model_construct(**changed))
        p, value = node.component.pack(node.parameters), evaluate(found.steps, q)
        for i, origin in found.assigned.items():
            p[i] = value(origin)
        assert p.tobytes() == expected.tobytes(), node.name


def test_cable_lets_all_its_quantities_be_set():
    node = next(n for n in build_graph(load_scenario(ROOT / "scenarios/pool_chain.yaml")).nodes if n.name == "tether")
    settable = {one.name for one in formulas(node.component, node.parameters).settable}
    assert {"length", "axial_stiffness", "mass_per_length", "normal_drag", "gravity", "rho_inf"} <= settable
    assert not settable & {"segments", "end_a", "tension_only"}


def test_parameters_set_in_the_fmu_are_those_of_the_component(fmu_of):
    """A chain made shorter, stiffer and in another fluid by setting it in the FMU, against p of such a chain."""
    node = next(n for n in build_graph(load_scenario(ROOT / "scenarios/pool_chain.yaml")).nodes if n.name == "tether")
    values = {"length": 2.5, "axial_stiffness": 1.7e5, "fluid_density": 1025.0, "normal_drag": 1.3}
    path = fmu_of("pool_chain.yaml#tether", 3)
    folder = fmpy.extract(str(path))
    about = fmpy.read_model_description(folder)
    references = {v.name: v.valueReference for v in about.modelVariables}
    inputs = [v.valueReference for v in about.modelVariables if v.causality == "input"]
    u = np.array([0, 0, 0.1, *[0.0] * 6, 1.9, 0, 0.5, *[0.0] * 6])
    fmu = FMU3Slave(
        guid=about.guid,
        unzipDirectory=folder,
        modelIdentifier=about.coSimulation.modelIdentifier,
        instanceName="a",
    )
    fmu.instantiate()
    fmu.enterInitializationMode()
    fmu.setFloat64([references[f"parameters.{name}"] for name in values], list(values.values()))
    fmu.setFloat64(inputs, list(u))
    fmu.exitInitializationMode()
    fmu.doStep(0.0, 0.02)
    found = np.array(fmu.getFloat64([references["nodes"]], 51 * 3))
    fmu.freeInstance()

    component = node.component
    changed = type(node.parameters).model_validate(dict(node.parameters) | values)
    sizes = component.sizes(changed)
    vectors = [component.pack(changed), u, np.zeros(sizes.state), np.zeros(node.width), np.zeros(sizes.workspace)]
    entry = bind(component)
    for address, t_ns in ((entry.init, 0), (entry.step, 20_000_000)):
        assert C_FUNCTION(address)(t_ns, 20_000_000, *(vector.ctypes.data for vector in vectors)) == 0
    assert found.tobytes() == vectors[3][: 51 * 3].tobytes()


def test_seed_is_a_parameter(fmu_of):
    """Another seed gives other noise; the scene's own is the start value."""
    path = fmu_of("pool_chain.yaml#hand", 3)
    about = fmpy.read_model_description(str(path))
    seed = next(v for v in about.modelVariables if v.name == "parameters.seed")
    node = next(n for n in build_graph(load_scenario(ROOT / "scenarios/pool_chain.yaml")).nodes if n.name == "hand")
    high, low = (int(float(half)) for half in seed.start.split())
    assert (high << 32) + low == node.seed
    runs = [
        fmpy.simulate_fmu(str(path), stop_time=1.0, step_size=0.02, output_interval=0.02, start_values=values)
        for values in ({}, {"parameters.seed": [1.0, 2.0]})
    ]
    names = [name for name in runs[0].dtype.names if name.startswith("motion.position")]
    assert names
    assert any((runs[0][name] != runs[1][name]).any() for name in names)
