"""What a component is: typed ports, validated parameters, and one function over five vectors.

`status = step(t_ns, dt_ns, p, u, x, y, w)` advances the state x over the dt_ns that end at t_ns and writes the
outputs y valid at t_ns. `init` has the same signature: it writes x and y at t_ns = t0, dt_ns being the period.
All five vectors are flat float64 arrays; y is write-only and w is scratch that lives for one call.

A component with images (ImagePort) is Python (`compiled=False`) and gets two more arguments, `images_in` and
`images_out`: the first maps each image input to its pixels, a read-only uint8 array that lives for one call; the second
is an empty dict, into which init and every step put a new uint8 array of the declared shape for each image output.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from math import prod
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

# Every p begins with seven numbers: the five vectors' lengths (without images) and the two 32-bit halves of the seed.
N_P, N_U, N_X, N_Y, N_W, SEED_HIGH, SEED_LOW, HEADER = range(8)

Kernel = Callable[..., int]


@dataclass(frozen=True)
class Port:
    """A named, shaped quantity in SI units that a component takes or gives.

    A dotted name (`motion.position`) is a member of a bundle (`motion`), which can be wired as a whole.
    frame: "NED" (world), "body", or "" for quantities that have none.
    """

    name: str
    unit: str
    shape: tuple[int, ...] = ()
    frame: str = ""
    description: str = ""

    @property
    def size(self) -> int:
        """Number of float64 the port takes in its vector (row-major)."""
        return prod(self.shape)


@dataclass(frozen=True)
class ImagePort(Port):
    """An image that a Python component takes or gives: uint8, (height, width) grey or (height, width, 3) RGB.

    Row 0 is the top. Images stand behind all other ports. An image is wired whole to another of the same shape, and is
    zeros (black) before its first; it is never state.
    """

    unit: str = "pixel"

    @property
    def size(self) -> int:
        """Number of float64 whose bytes hold the pixels, the last ones filled up with zeros."""
        return -(-self.pixels // 8)

    @property
    def pixels(self) -> int:
        """Number of bytes."""
        return prod(self.shape)

    def in_words(self, words: np.ndarray) -> np.ndarray:
        """The image, a view of its float64: (size,)."""
        return words.view(np.uint8)[: self.pixels].reshape(self.shape)


def parted(ports: Iterable[Port]) -> tuple[tuple[Port, ...], tuple[ImagePort, ...]]:
    """The ports that are numbers, and those that are images and stand behind them."""
    ports = tuple(ports)
    images = tuple(port for port in ports if isinstance(port, ImagePort))
    return ports[: len(ports) - len(images)], images


def numbers_in(ports: Iterable[Port]) -> int:
    """How many float64 the ports take that are no images."""
    return sum(port.size for port in parted(ports)[0])


def placed_images(ports: Iterable[Port]) -> Iterator[tuple[ImagePort, slice]]:
    """The image ports, and where each one's float64 are in the vector of all ports."""
    start = 0
    for port in ports:
        if isinstance(port, ImagePort):
            yield port, slice(start, start + port.size)
        start += port.size


def motion_ports(bundle: str) -> tuple[Port, ...]:
    """Ports of a moving point: position [m], velocity [m/s], acceleration [m/s^2], each (3,) in NED."""
    return (
        Port(f"{bundle}.position", "m", (3,), "NED"),
        Port(f"{bundle}.velocity", "m/s", (3,), "NED"),
        Port(f"{bundle}.acceleration", "m/s^2", (3,), "NED"),
    )


def law_ports(bundle: str) -> tuple[Port, ...]:
    """Ports of an affine force law F(a) = force - mass (a - acceleration), a line's on a body, in NED.

    force: (3,) [N]; acceleration: (3,) the reference a [m/s^2]; mass: (3, 3) symmetric -dF/da [kg].
    """
    return (
        Port(f"{bundle}.force", "N", (3,), "NED"),
        Port(f"{bundle}.acceleration", "m/s^2", (3,), "NED"),
        Port(f"{bundle}.mass", "kg", (3, 3), "NED"),
    )


def quantity(unit: str, description: str, default: Any = ..., *, tunable: bool = False, **bounds: Any) -> Any:
    """Declare a parameter with its SI unit ("1": dimensionless); bounds as in pydantic's Field (gt, le, ...)."""
    return Field(default, description=description, json_schema_extra={"unit": unit, "tunable": tunable}, **bounds)


def choice(description: str, default: Any = ...) -> Any:
    """Declare a parameter that is no quantity: a name, a count or a switch (fixed during a run)."""
    return Field(default, description=description, json_schema_extra={"unit": None, "tunable": False})


class Parameters(BaseModel):
    """A component's parameters: frozen, in SI units and radians, unknown names refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def vector(self) -> np.ndarray:
        """The numbers of p after its header, derived values included: (n,) float64.

        By default all numeric fields in the order they are declared, arrays flattened.
        """
        values = [getattr(self, name) for name in type(self).model_fields]
        numbers = [np.ravel(v) for v in values if not isinstance(v, str) and v is not None]
        return np.concatenate([np.asarray(v, np.float64) for v in numbers]) if numbers else np.empty(0)


@dataclass(frozen=True)
class Sizes:
    """Lengths of the state x and of the scratch vector w."""

    state: int = 0
    workspace: int = 0


@dataclass(frozen=True)
class BodyEnd:
    """Where a body takes a line: gives a motion bundle, takes a force-law bundle, moves by the line's scheme.

    motion: output bundle, see motion_ports. law: input bundle, see law_ports.
    switch: the boolean parameter that turns the input on (a body without a bond has nothing to wire there), "" if
        it is always there.
    accelerance: output port (3, 3) [1/kg], NED, symmetric: how much the end's acceleration grows with a force there, in
        the balance that the body solves (position and velocity following by the scheme; zero along a direction in which
        it cannot move). With it a line between two bodies is balanced for both at once; "" if the body does not tell.
    """

    motion: str
    law: str
    switch: str = ""
    accelerance: str = ""


@dataclass(frozen=True)
class LineEnd:
    """An end of a line that can be bonded to a body.

    motion: input bundle of the end. force: output port, the line's force on what holds the end.
    law: output bundle, the law for the body's next step.
    accepted: output bundle, the law about the motion just accepted, for repeating the same step.
    switch: the boolean parameter that turns both outputs on (a line without a bond does not pay for them).
    stiffness: of the parameters, the taut line's axial stiffness [N/m] between its ends.
    """

    motion: str
    force: str
    law: str
    accepted: str
    switch: str
    stiffness: Callable[[Any], float]


@dataclass(frozen=True)
class Term:
    """A part of a model that a scene may do without.

    why: in words, with the number that turns it on or leaves it off.
    """

    name: str
    on: bool
    why: str


def _no_terms(_: Any) -> tuple[Term, ...]:
    return ()


def _no_ports(_: Any) -> tuple[Port, ...]:
    return ()


def _no_sizes(_: Any) -> Sizes:
    return Sizes()


def _no_defaults(_: Any) -> Mapping[str, tuple[float, ...]]:
    return {}


@dataclass(frozen=True)
class Component:
    """One kind of component: what `components/<family>/<name>/component.py` binds together as COMPONENT.

    inputs, outputs, sizes: functions of the parameters, fixed before init.
    init, step: plain functions of the contract's signature. With `compiled` they are compiled by numba on first use
        and may call functions made by `components.compiled.kernel`; else they are called as Python, with images if
        there are image ports.
    status_text: what each positive status means; such a status stops the run.
    bodies, lines: the ends at which a power bond can be tied, by name.
    cross: for two ends (a, b) of a line that are both bonded, the output port (3, 3) of -dF_a / d acceleration_b [kg]
        about the motion just accepted, beside both ends' `accepted`.
    terms: of the parameters, the parts of the model that can be off, and which are on.
    validity: a scalar output, at most 1 inside the range in which the model is valid and above 1 outside; the other
        members of its bundle are the measures of which it is the largest. "" if the model does not tell.
    assumptions: what the model leaves out and where it is valid, one sentence.
    defaults: of the parameters, the inputs that may be left without a wire, and the numbers which they hold then.
    absent: what looks like a port and cannot be wired, by name, and why.
    """

    name: str
    parameters: type[Parameters]
    init: Kernel
    step: Kernel
    outputs: Callable[[Any], tuple[Port, ...]]
    inputs: Callable[[Any], tuple[Port, ...]] = _no_ports
    sizes: Callable[[Any], Sizes] = _no_sizes
    status_text: Mapping[int, str] = field(default_factory=dict)
    bodies: Mapping[str, BodyEnd] = field(default_factory=dict)
    lines: Mapping[str, LineEnd] = field(default_factory=dict)
    cross: Mapping[tuple[str, str], str] = field(default_factory=dict)
    compiled: bool = True
    terms: Callable[[Any], tuple[Term, ...]] = _no_terms
    validity: str = ""
    assumptions: str = ""
    defaults: Callable[[Any], Mapping[str, tuple[float, ...]]] = _no_defaults
    absent: Mapping[str, str] = field(default_factory=dict)

    def pack(self, parameters: Parameters, seed: int = 0) -> np.ndarray:
        """The vector p with its header; seed: 64 bits."""
        sizes = self.sizes(parameters)
        numbers = parameters.vector()
        n_u, n_y = numbers_in(self.inputs(parameters)), numbers_in(self.outputs(parameters))
        header = [HEADER + len(numbers), n_u, sizes.state, n_y, sizes.workspace, seed >> 32, seed & 0xFFFFFFFF]
        return np.concatenate([np.array(header, np.float64), numbers])
