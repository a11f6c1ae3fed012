"""Which parameters an FMU can still set, and how p follows from them.

A component's p comes from `Parameters.vector()`, which is Python. It is run here with numbers that remember how they
were computed. A parameter can be set where every number of p that depends on it was computed by plain arithmetic, so
that the same arithmetic in C gives the same bits, and where nothing was decided by its value: no comparison, no
validator that looks at several parameters, no port or size. Others are fixed when the FMU is built.
"""

from __future__ import annotations

import inspect
import random
from dataclasses import dataclass
from functools import partial
from math import isfinite
from typing import Any

import numpy as np

from components.contract import HEADER, Component, Parameters
from pipeline.fmu.limits import Quantity, quantities
from pipeline.fmu.traced import Leaf, Operand, Step, Trace, Traced, bits, evaluate

TRIALS = 4  # sets of values with which the formulas are tried against vector(), bit by bit


@dataclass(frozen=True)
class Formulas:
    """The numbers that can be set (a parameter's stand together), and the numbers of p that depend on them.

    assigned: index in p -> what it is, of the steps and the numbers set (a Leaf's i counts these).
    """

    settable: tuple[Quantity, ...]
    steps: tuple[Step, ...]
    assigned: dict[int, Operand]


def formulas(component: Component, parameters: Parameters) -> Formulas:
    """What can be set: found by tracing, confirmed by trials in which every number of p must agree bit by bit."""
    looked_at = _looked_at_together(parameters)
    candidates = [one for one in quantities(parameters) if one.name not in looked_at]
    names = dict.fromkeys(one.name for one in candidates)
    fit = [name for name in names if _attempt(component, parameters, [q for q in candidates if q.name == name])]
    together = _attempt(component, parameters, [one for one in candidates if one.name in fit])
    return together or Formulas((), (), {})


def _attempt(component: Component, parameters: Parameters, varied: list[Quantity]) -> Formulas | None:
    """The formulas if all of the numbers can be set, else None."""
    try:
        trace, vector = _run(component, parameters, varied)
        found = Formulas(tuple(varied), tuple(trace.steps), _assigned(trace, vector))
        trials = [_agrees(component, parameters, found, _trial(varied, seed)) for seed in range(1, 1 + TRIALS)]
        as_given = _agrees(component, parameters, found, [one.value for one in varied])
    except Exception:  # of a vector() that takes no such number, or that these values do not suit
        return None
    return found if not trace.decisive and as_given and all(trials) else None


class _Reader:
    """Parameters that note which of their fields are read."""

    def __init__(self, parameters: Parameters, seen: set[str]):
        self._parameters, self._seen = parameters, seen

    def __getattr__(self, name: str) -> Any:
        kind = type(self._parameters)
        found = inspect.getattr_static(kind, name, None)
        if name not in kind.model_fields and inspect.isfunction(found):
            return partial(found, self)
        if isinstance(found, property) and found.fget is not None:
            return found.fget(self)
        self._seen.add(name)
        return getattr(self._parameters, name)


def _looked_at_together(parameters: Parameters) -> set[str]:
    """Parameters that a validator beside their bounds looks at; what it would refuse is not known in C."""
    kind = type(parameters)
    decorators = kind.__pydantic_decorators__
    seen: set[str] = set()
    for decorator in decorators.field_validators.values():
        seen |= set(decorator.info.fields)
    for decorator in decorators.model_validators.values():
        if decorator.info.mode != "after":
            return set(kind.model_fields)
        getattr(decorator.func, "__func__", decorator.func)(_Reader(parameters, seen))
    return seen


def _with(parameters: Parameters, varied: tuple[Quantity, ...] | list[Quantity], values: list[Any]) -> Any:
    """The parameters with some of their numbers replaced, without validation."""
    changed = {name: getattr(parameters, name) for name in type(parameters).model_fields}
    for one, value in zip(varied, values, strict=True):
        old = changed[one.name]
        changed[one.name] = value if one.index is None else (*old[: one.index], value, *old[one.index + 1 :])
    return type(parameters).model_construct(**changed)


def _layout(component: Component, parameters: Any) -> tuple[Any, ...]:
    return component.inputs(parameters), component.outputs(parameters), component.sizes(parameters)


def _trial(varied: list[Quantity], seed: int) -> list[float]:
    """Values within the bounds, near those given, whose bits nothing else has."""
    draw = random.Random(seed)
    values = []
    for one in varied:
        bounds = one.bounds
        value = one.value * draw.uniform(0.5, 1.5) if one.value else draw.uniform(-1.0, 1.0)
        if not bounds.low < value < bounds.high:
            low = bounds.low if isfinite(bounds.low) else bounds.high - 1.0
            value = draw.uniform(low, bounds.high if isfinite(bounds.high) else low + 1.0)
        values.append(value)
    return values


def _run(component: Component, parameters: Parameters, varied: list[Quantity]) -> tuple[Trace, np.ndarray]:
    """vector() with traced numbers, its layout traced as well."""
    trace = Trace()
    traced = [Traced(value, Leaf(i), frozenset([i]), trace) for i, value in enumerate(_trial(varied, 0))]
    changed = _with(parameters, varied, traced)
    _layout(component, changed)
    return trace, changed.vector()


def _assigned(trace: Trace, vector: np.ndarray) -> dict[int, Operand]:
    """The numbers of p that are results of the trace, by their bits."""
    found = {HEADER + i: trace.results.get(bits(value)) for i, value in enumerate(vector.tolist())}
    return {i: origin for i, origin in found.items() if origin is not None}


def _agrees(component: Component, parameters: Parameters, found: Formulas, values: list[float]) -> bool:
    """Whether the formulas give vector()'s bits with these values, and the layout stays as it is."""
    changed = _with(parameters, found.settable, values)
    if _layout(component, changed) != _layout(component, parameters):
        return False
    expected, p = component.pack(changed), component.pack(parameters)
    value = evaluate(found.steps, values)
    for i, origin in found.assigned.items():
        p[i] = value(origin)
    return p.tobytes() == expected.tobytes()
