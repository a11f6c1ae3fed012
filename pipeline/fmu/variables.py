"""The variables of an FMU, made from a component's ports and parameters; value references count them from 0."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from math import prod
from typing import Any, Literal

import numpy as np

from components.contract import SEED_HIGH, SEED_LOW, Component, Parameters, Port
from pipeline.fmu.formulas import Formulas, formulas
from pipeline.fmu.limits import Bounds
from pipeline.fmu.traced import Leaf
from pipeline.kernels import names_in
from pipeline.parameters import unit_of

Role = Literal["time", "input", "output", "parameter", "constant"]
Type = Literal["real", "integer", "boolean", "text"]
PARAMETERS = "parameters"  # the bundle that parameters are in: one may be called as a port is
SEED = f"{PARAMETERS}.seed"
LARGEST = 1000  # numbers of a constant that is shown: above, it is a table and no parameter to read
HALF = 2.0**32  # the seed is given by two halves
WHOLE = Bounds(0.0, HALF - 1.0)


@dataclass(frozen=True)
class Variable:
    """One variable: a port, a parameter, or a number fixed when the FMU is built.

    start: its values row by row; of an output none. first: where they stand among the numbers of its role and type.
    bounds: of each number of a parameter.
    """

    name: str
    role: Role
    unit: str = "1"
    shape: tuple[int, ...] = ()
    description: str = ""
    start: tuple[Any, ...] = ()
    first: int = 0
    type: Type = "real"
    frame: str = ""
    bounds: tuple[Bounds, ...] = ()
    tunable: bool = False

    @property
    def size(self) -> int:
        """How many numbers it holds."""
        return prod(self.shape)


def independent(variables: tuple[Variable, ...]) -> Variable:
    """The time, which FMI 3 asks for, by a name that none of the variables has: a sensor's port may be `time`."""
    name = "time"
    while name in {one.name for one in variables}:
        name = f"simulated_{name}"
    return Variable(name, "time", "s", description="simulated time")


@dataclass(frozen=True)
class Contents:
    """A component with parameters, as an FMU shows it: variables, and how p follows from those that can be set."""

    component: Component
    parameters: Parameters
    seed: int
    variables: tuple[Variable, ...]
    formulas: Formulas


def contents(component: Component, parameters: Parameters, seed: int, inputs: tuple[float, ...] = ()) -> Contents:
    """Inputs, outputs, parameters that can be set, and those that are fixed; empty ports are left out.

    inputs: (n_u,) start values, or none for zero.
    """
    found = formulas(component, parameters)
    has_seed = bool({"SEED_HIGH", "SEED_LOW"} & names_in(component))
    variables = [
        *_ports(component.inputs(parameters), "input", inputs),
        *_ports(component.outputs(parameters), "output"),
        *_settable(parameters, found),
        *(_seed(seed, len(found.settable)) if has_seed else ()),
        *_fixed(parameters, found),
    ]
    if has_seed:
        k = len(found.settable)
        found = replace(found, assigned=found.assigned | {SEED_HIGH: Leaf(k), SEED_LOW: Leaf(k + 1)})
    return Contents(component, parameters, seed, tuple(variables), found)


def elements(variables: tuple[Variable, ...]) -> tuple[Variable, ...]:
    """Each number as a variable of its own, `nodes[1,3]` counted from 1: FMI 2 has no arrays."""
    found = []
    for one in variables:
        if not one.shape:
            found.append(one)
            continue
        for k, place in enumerate(product(*(range(1, n + 1) for n in one.shape))):
            name = f"{one.name}[{','.join(map(str, place))}]"
            own = {"start": one.start[k : k + 1], "bounds": one.bounds[k : k + 1], "first": one.first + k}
            found.append(replace(one, name=name, shape=(), **own))
    return tuple(found)


def _ports(ports: tuple[Port, ...], role: Role, inputs: tuple[float, ...] = ()) -> list[Variable]:
    found, first = [], 0
    for port in ports:
        zero = (0.0,) * port.size if role == "input" else ()
        start = inputs[first : first + port.size] or zero
        if port.size:
            found.append(
                Variable(port.name, role, port.unit, port.shape, port.description, start, first, frame=port.frame)
            )
        first += port.size
    return found


def _about(parameters: Parameters, name: str) -> dict[str, str]:
    about = type(parameters).model_fields[name]
    return {"unit": unit_of(type(parameters), name) or "1", "description": about.description or ""}


def _settable(parameters: Parameters, found: Formulas) -> list[Variable]:
    variables: list[Variable] = []
    for first, number in enumerate(found.settable):
        name = f"{PARAMETERS}.{number.name}"
        if variables and variables[-1].name == name:
            before = variables[-1]
            start, bounds = (*before.start, number.value), (*before.bounds, number.bounds)
            variables[-1] = replace(before, start=start, bounds=bounds, shape=(len(start),))
        else:
            shape = () if number.index is None else (1,)
            own = {"first": first, "bounds": (number.bounds,), "tunable": number.tunable, "start": (number.value,)}
            variables.append(Variable(name, "parameter", shape=shape, **_about(parameters, number.name), **own))
    return variables


def _seed(seed: int, first: int) -> list[Variable]:
    halves = (float(seed >> 32), float(seed & 0xFFFFFFFF))
    about = "high and low 32 bits of the seed of its random numbers, whole"
    return [Variable(SEED, "parameter", "1", (2,), about, halves, first, bounds=(WHOLE, WHOLE))]


def _fixed(parameters: Parameters, found: Formulas) -> list[Variable]:
    """What was decided when the FMU was built: quantities, counts, switches and names, but no large tables."""
    settable = {number.name for number in found.settable}
    counts = {"real": 0, "integer": 0, "boolean": 0, "text": 0}
    variables: list[Variable] = []
    for name in type(parameters).model_fields:
        value = getattr(parameters, name)
        array = _numbers(value) if unit_of(type(parameters), name) is not None else None
        kind: Type | None = "real" if array is not None else _type_of(value)
        if name in settable or kind is None:
            continue
        start = (value,) if array is None else tuple(array.ravel().tolist())
        shape = () if array is None else array.shape
        own = {"start": start, "first": counts[kind], "type": kind}
        variables.append(Variable(f"{PARAMETERS}.{name}", "constant", shape=shape, **_about(parameters, name), **own))
        counts[kind] += len(start)
    return variables


def _numbers(value: Any) -> np.ndarray | None:
    """A quantity's numbers if they are an array that is worth showing."""
    try:
        array = np.array(value, np.float64)
    except (TypeError, ValueError):  # of ragged tables and of other models
        return None
    return array if 0 < array.size <= LARGEST and np.isfinite(array).all() else None


def _type_of(value: Any) -> Type | None:
    if isinstance(value, bool):
        return "boolean"
    if isinstance(value, int):
        return "integer" if abs(value) < 2**31 else None
    return "text" if isinstance(value, str) else None
