"""The parameters of an FMU as a class of the contract: validated as any component's, by the names in the FMU."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import ceil, floor
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import BeforeValidator, ConfigDict, Field, create_model

from components.contract import Parameters, choice, quantity
from pipeline.hosts.fmu.description import Description, FmuError
from pipeline.hosts.fmu.kinds import FLOAT32, HIGH, INT64, LOW, UINT64
from pipeline.hosts.fmu.variables import Variable

WIDE = {INT64: (-(2**63), 2**63 - 1), UINT64: (0, 2**64 - 1)}  # a parameter is set as it is, not by way of a float64


class FmuParameters(Parameters):
    """Parameters and start values of an FMU. VARIABLES: by the names of the fields."""

    model_config = ConfigDict(protected_namespaces=())
    VARIABLES: ClassVar[Mapping[str, Variable]] = {}

    def vector(self) -> np.ndarray:
        """Those that events may change, in the units of the FMU."""
        return np.array([number for name in self.tunable() for number in self.numbers(name)], np.float64)

    @classmethod
    def tunable(cls) -> list[str]:
        """The names of those that events may change, in the order of the numbers of p."""
        return [name for name, one in cls.VARIABLES.items() if is_tunable(one)]

    def values(self, name: str) -> list[Any]:
        """A variable's values as the FMU takes them, flat; Python's numbers, truths and texts."""
        one, found = self.VARIABLES[name], list(flat(getattr(self, name)))
        return [one.unit.to_fmu(number) for number in found] if one.kind.is_real else found

    def numbers(self, name: str) -> list[float]:
        """The same as float64."""
        return [float(value) for value in self.values(name)]

    def changed(self) -> list[str]:
        """The names of those that are not as the FMU starts by itself."""
        fields = type(self).model_fields
        return [
            name for name in fields if getattr(self, name) is not None and getattr(self, name) != fields[name].default
        ]

    def shape(self, one: Variable) -> tuple[int, ...]:
        """Of an array, whose lengths may be structural parameters."""
        if not one.dimensions:
            return one.shape
        lengths = {-1 - v.references[0]: getattr(self, name) for name, v in self.VARIABLES.items() if not v.shape}
        return tuple(length if length >= 0 else int(lengths[length]) for length in one.dimensions)


def is_tunable(one: Variable) -> bool:
    """Whether an event may change it during a run."""
    is_set = one.start is not None and one.kind.is_number
    return one.causality == "parameter" and one.variability == "tunable" and is_set


def parameters_of(description: Description) -> type[FmuParameters]:
    """The class of an FMU's parameters. Raises FmuError where a start value is none."""
    variables = {one.name: one for one in description.variables if one.causality != "output"}
    fields: Any = {name: _field(one) for name, one in variables.items()}
    kind = create_model(f"{description.model} ({description.path.name})", __base__=FmuParameters, **fields)
    kind.VARIABLES = variables
    return kind


def _field(one: Variable) -> tuple[Any, Any]:
    default = _default(one)
    of_one = _type(one)
    kind = _nested(of_one, one, one.shape) if one.shape else of_one
    about = one.description or one.title
    if one.kind.is_real:
        field = quantity(one.unit.unit, about, default, tunable=is_tunable(one))
    else:
        field = choice(about, default)
        field.json_schema_extra["tunable"] = is_tunable(one)
    return (kind if default is not None else kind | None), field


def _type(one: Variable) -> Any:
    """The type of a single value."""
    if not one.kind.is_number:
        return Annotated[str, BeforeValidator(_hexadecimal)] if one.kind.name == "Binary" else str
    if one.kind.is_boolean:
        return bool
    if one.kind.is_real:
        low, high = _reals(one)
        return Annotated[float, Field(ge=low, le=high)]
    low, high = WIDE.get(one.kind.code, (LOW[one.kind.code], HIGH[one.kind.code]))
    if is_tunable(one):
        low, high = LOW[one.kind.code], HIGH[one.kind.code]
    low = int(low) if one.low is None else max(int(low), ceil(one.low))
    high = int(high) if one.high is None else min(int(high), floor(one.high))
    whole = Annotated[int, Field(ge=low, le=high)]
    if not one.items:
        return whole
    numbers = dict(one.items)
    return Annotated[int, Field(ge=low, le=high), BeforeValidator(lambda value: _item(value, numbers))]


def _reals(one: Variable) -> tuple[float | None, float | None]:
    """Bounds of a floating-point number in SI: the FMU's, or those of a Float32 where it tells none."""
    if one.kind.code != FLOAT32:
        return one.low, one.high
    low, high = sorted((one.unit.to_si(LOW[FLOAT32]), one.unit.to_si(HIGH[FLOAT32])))
    return low if one.low is None else one.low, high if one.high is None else one.high


def _nested(kind: Any, one: Variable, shape: tuple[int, ...]) -> Any:
    """Lists in lists of the shape; where structural parameters decide it, of any length."""
    if not shape:
        return kind
    inner = _nested(kind, one, shape[1:])
    if any(length < 0 for length in one.dimensions):
        return tuple[inner, ...]
    return Annotated[tuple[inner, ...], Field(min_length=shape[0], max_length=shape[0])]


def _default(one: Variable) -> Any:
    """The FMU's own start value in SI, nested; None where it has none."""
    if one.start is None:
        return None
    values = [one.unit.to_si(value) for value in one.start] if one.kind.is_real else list(one.start)
    if not one.shape:
        return values[0]
    return _shaped(values, one.shape)


def _shaped(values: list[Any], shape: tuple[int, ...]) -> Any:
    if len(shape) == 1:
        return tuple(values)
    width = len(values) // shape[0] if shape[0] else 0
    return tuple(_shaped(values[k * width : (k + 1) * width], shape[1:]) for k in range(shape[0]))


def flat(value: Any) -> Iterator[Any]:
    """The values in lists in lists, one after another."""
    if isinstance(value, tuple | list):
        for inner in value:
            yield from flat(inner)
    else:
        yield value


def _item(value: Any, numbers: dict[str, int]) -> Any:
    """The number of an enumeration's item."""
    if isinstance(value, str) and value not in numbers:
        raise ValueError(f"'{value}' is no item; expected one of {', '.join(numbers)}")
    if isinstance(value, int) and not isinstance(value, bool) and value not in numbers.values():
        raise ValueError(f"{value} is no item; expected one of {', '.join(numbers)}")
    return numbers[value] if isinstance(value, str) else value


def _hexadecimal(value: Any) -> Any:
    if isinstance(value, str):
        try:
            return bytes.fromhex(value).hex()
        except ValueError:
            raise ValueError(f"'{value[:40]}' is not hexadecimal, which binary values are written in") from None
    return value


def checked_shapes(parameters: FmuParameters) -> None:
    """Raise FmuError where an array's values are not as many as its structural parameters say."""
    for name, one in parameters.VARIABLES.items():
        given = getattr(parameters, name)
        if given is None or not any(length < 0 for length in one.dimensions):
            continue
        wanted = parameters.shape(one)
        found = np.shape(given)
        if given != type(parameters).model_fields[name].default and found != wanted:
            raise FmuError(f"'{name}' is {found}, and its structural parameters make it {wanted}")
