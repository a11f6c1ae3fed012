"""An FMU as a component of the contract: ports from its description, called by a host instead of being compiled."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

from components.contract import Component, Port
from pipeline.hosts.fmu.description import Description, Interface, read
from pipeline.hosts.fmu.parameters import FmuParameters, checked_shapes, flat, parameters_of
from pipeline.hosts.fmu.variables import Variable

ASSUMPTIONS = "whatever its FMU assumes"


@dataclass(frozen=True)
class FmuComponent(Component):
    """One interface of an FMU.

    isolate: in a process of its own. overdue_s: wall time after which a call is taken to hang, 0 for the usual one.
    inputs_in_fmu, outputs_in_fmu: what the ports are in the FMU, in order.
    """

    description: Description = field(kw_only=True)
    interface: Interface = field(kw_only=True)
    isolate: bool = field(kw_only=True, default=False)
    overdue_s: float = field(kw_only=True, default=0.0)

    @property
    def inputs_in_fmu(self) -> list[Variable]:
        """What the input ports are, in order."""
        return [one for one in self.description.of("input") if one.kind.is_number]

    @property
    def outputs_in_fmu(self) -> list[Variable]:
        """What the output ports are, in order."""
        return self.description.of("output")

    def faults(self, period_ns: int) -> list[str]:
        """Why it cannot be stepped with this period."""
        fixed = self.interface.fixed_step_s
        if fixed is None or period_ns == 0:
            return []
        whole = round(period_ns / 1e9 / fixed)
        # Decimal step sizes are not exact in binary; half a nanosecond is below what the period resolves.
        if whole >= 1 and abs(whole * fixed * 1e9 - period_ns) < 0.5:
            return []
        return [
            f"its FMU steps by {fixed:g} s (fixedInternalStepSize), and {period_ns / 1e9:g} s is no multiple of that"
        ]


def _never(*_: Any) -> int:
    raise AssertionError("an FMU is stepped by its host")


def component_of(path: Path, interface: str = "", *, isolate: bool = False, overdue_s: float = 0.0) -> FmuComponent:
    """The component that the FMU at `path` is. interface: "" for co-simulation where there is one. Raises FmuError."""
    return _component(read(path), interface, isolate, overdue_s)


@lru_cache(64)
def _component(description: Description, interface: str, isolate: bool, overdue_s: float) -> FmuComponent:
    return FmuComponent(
        name=description.model,
        parameters=parameters_of(description),
        init=_never,
        step=_never,
        inputs=lambda p: _ports(p, [one for one in description.of("input") if one.kind.is_number]),
        outputs=lambda p: _ports(p, description.of("output")),
        defaults=lambda p: _defaults(p, description),
        absent=description.refused,
        compiled=False,
        assumptions=description.summary or ASSUMPTIONS,
        validity=description.validity,
        description=description,
        interface=description.interface(interface),
        isolate=isolate,
        overdue_s=overdue_s,
    )


def _ports(parameters: FmuParameters, variables: list[Variable]) -> tuple[Port, ...]:
    checked_shapes(parameters)
    return tuple(Port(one.name, one.unit.unit, parameters.shape(one), one.frame, one.description) for one in variables)


def _defaults(parameters: FmuParameters, description: Description) -> dict[str, tuple[float, ...]]:
    """What inputs hold that are not wired, in SI: their start values."""
    found = {}
    for one in description.of("input"):
        if one.kind.is_number and getattr(parameters, one.name) is not None:
            found[one.name] = tuple(float(value) for value in flat(getattr(parameters, one.name)))
    return found
