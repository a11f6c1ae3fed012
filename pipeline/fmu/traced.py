"""Numbers that remember how they were computed."""

from __future__ import annotations

import operator
import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from math import isfinite
from typing import Any, NamedTuple

import numpy as np


class Leaf(NamedTuple):
    """The i-th of the numbers that a trace begins with."""

    i: int


class Result(NamedTuple):
    """What the i-th step gave."""

    i: int


Operand = Leaf | Result | float


class Step(NamedTuple):
    """One operation: + - * / of two operands, or `neg` or `abs` of one."""

    operation: str
    operands: tuple[Operand, ...]


OPERATIONS: dict[str, Callable[..., Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "neg": operator.neg,
    "abs": abs,
}


def bits(value: float) -> bytes:
    """The eight bytes of a double."""
    return struct.pack("<d", value)


@dataclass
class Trace:
    """What happened to traced numbers.

    results: every number by its bits; decisive: the leaves on whose value a decision hung.
    """

    steps: list[Step] = field(default_factory=list)
    results: dict[bytes, Leaf | Result] = field(default_factory=dict)
    decisive: set[int] = field(default_factory=set)


class Traced(float):
    """A float that knows where in a trace it comes from; `leaves`: those that it depends on."""

    origin: Leaf | Result
    leaves: frozenset[int]
    trace: Trace
    __array_ufunc__ = None  # numpy's scalars leave arithmetic with it to this class

    def __new__(cls, value: float, origin: Leaf | Result, leaves: frozenset[int], trace: Trace) -> Traced:
        """A number that the trace knows by its bits from then on."""
        self = super().__new__(cls, value)
        self.origin, self.leaves, self.trace = origin, leaves, trace
        trace.results.setdefault(bits(value), origin)
        return self

    def _step(self, operation: str, *values: Any) -> Any:
        """The traced result of an operation, in which this number is one of the values."""
        operands = [_operand(value) for value in values]
        plain = [float.__pos__(value) if isinstance(value, Traced) else value for value in values]
        if any(operand is None for operand in operands):
            return OPERATIONS[operation](*plain)
        result = OPERATIONS[operation](*plain)
        if not isfinite(result):
            return result
        self.trace.steps.append(Step(operation, tuple(operand for operand in operands if operand is not None)))
        leaves = frozenset(leaf for value in values if isinstance(value, Traced) for leaf in value.leaves)
        return Traced(result, Result(len(self.trace.steps) - 1), leaves, self.trace)

    def _decide(self, *others: Any) -> None:
        for value in (self, *others):
            self.trace.decisive |= value.leaves if isinstance(value, Traced) else frozenset()

    def __add__(self, other: Any) -> Any:
        return self._step("+", self, other)

    def __radd__(self, other: Any) -> Any:
        return self._step("+", other, self)

    def __sub__(self, other: Any) -> Any:
        return self._step("-", self, other)

    def __rsub__(self, other: Any) -> Any:
        return self._step("-", other, self)

    def __mul__(self, other: Any) -> Any:
        return self._step("*", self, other)

    def __rmul__(self, other: Any) -> Any:
        return self._step("*", other, self)

    def __truediv__(self, other: Any) -> Any:
        return self._step("/", self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return self._step("/", other, self)

    def __neg__(self) -> Any:
        return self._step("neg", self)

    def __pos__(self) -> Any:
        return self

    def __abs__(self) -> Any:
        return self._step("abs", self)

    def __lt__(self, other: Any) -> bool:
        self._decide(other)
        return float.__lt__(self, other)

    def __le__(self, other: Any) -> bool:
        self._decide(other)
        return float.__le__(self, other)

    def __gt__(self, other: Any) -> bool:
        self._decide(other)
        return float.__gt__(self, other)

    def __ge__(self, other: Any) -> bool:
        self._decide(other)
        return float.__ge__(self, other)

    def __eq__(self, other: object) -> bool:
        self._decide(other)
        return float.__eq__(self, other)

    def __ne__(self, other: object) -> bool:
        self._decide(other)
        return float.__ne__(self, other)

    def __bool__(self) -> bool:
        self._decide()
        return float.__bool__(self)

    def __hash__(self) -> int:
        self._decide()
        return float.__hash__(self)


def _operand(value: Any) -> Operand | None:
    """What a step can name: a traced number, or one that a double holds exactly; None for anything else."""
    if isinstance(value, Traced):
        return value.origin
    if isinstance(value, bool | int | float | np.floating | np.integer) and isfinite(value) and float(value) == value:
        return float(value)
    return None


def evaluate(steps: tuple[Step, ...], leaves: list[float]) -> Callable[[Operand], float]:
    """The steps made with other leaves; returns what gives an operand's value then."""
    results: list[float] = []

    def value(operand: Operand) -> float:
        if isinstance(operand, Leaf):
            return leaves[operand.i]
        return results[operand.i] if isinstance(operand, Result) else operand

    for step in steps:
        results.append(OPERATIONS[step.operation](*(value(operand) for operand in step.operands)))
    return value
