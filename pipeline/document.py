"""What a scenario file may say: the pydantic models of its parts, and their errors in words with places."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Annotated, Any, Literal, TypeVar

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, ValidationError
from pydantic_core import ErrorDetails

from pipeline.catalogue import closest
from pipeline.errors import Place, Problem
from pipeline.quantities import nanoseconds, shown, si_value
from pipeline.yaml_source import Items, Table, Tree, plain

IDENTIFIER = re.compile(r"[a-z][a-z0-9_]*")
NOT_A_NAME = "not a name; expected small letters, digits and _, beginning with a letter"
_EVERY = re.compile(r"every\s+(.+)")
_NAME = re.compile(r"(?!\.)[A-Za-z0-9_. -]{1,64}")


@dataclass(frozen=True)
class Record:
    """Which of a component's steps are logged: every `steps` own steps (0: none), or one each period_ns."""

    steps: int = 1
    period_ns: int = 0


def name_from(stem: str) -> str:
    """A scenario's name made from its file's: other characters than those of a name become _."""
    return re.sub(r"[^A-Za-z0-9_. -]", "_", stem)[:64].lstrip(".") or "scenario"


def _name(value: str) -> str:
    if not _NAME.fullmatch(value):
        raise ValueError(
            f"{shown(value)} cannot name a log; expected up to 64 letters, digits, spaces, _, - and ., "
            "not beginning with a dot"
        )
    return value


def _start(value: object) -> int:
    time = nanoseconds(value)
    if time < 0:
        raise ValueError(f"{shown(value)} is before zero; expected e.g. '0 s'")
    return time


def _duration(value: object) -> int:
    return _positive(nanoseconds(value), value)


def _period(value: object) -> int:
    if isinstance(value, int | float) and not isinstance(value, bool):
        raise ValueError(f"{shown(value)} has no unit; expected a time or a rate, such as '20 ms' or '50 Hz'")
    return _positive(nanoseconds(value, rate=True), value)


def _positive(time: int, value: object) -> int:
    if time <= 0:
        raise ValueError(f"{shown(value)} is not above zero; expected e.g. '20 ms'")
    return time


def _scene(value: object) -> int | None:
    return None if value is False else _period(value)


def _record(value: object) -> Record:
    if isinstance(value, bool):
        return Record(int(value))
    match = _EVERY.fullmatch(value) if isinstance(value, str) else None
    if match is None:
        raise ValueError(f"{shown(value)} is no record rate; expected 'every 5' (own steps), 'every 100 ms' or false")
    if not re.fullmatch(r"[0-9]{1,9}", match[1]):
        return Record(0, _period(match[1]))
    if int(match[1]) == 0:
        raise ValueError("'every 0' is not above zero; expected false to record nothing")
    return Record(int(match[1]))


def _newton(value: object) -> float:
    force = si_value(value, "N")
    if force <= 0:
        raise ValueError(f"{shown(value)} is not above zero; expected e.g. '1 mN'")
    return force


Time = Annotated[int, BeforeValidator(nanoseconds)]
Start = Annotated[int, BeforeValidator(_start)]
Duration = Annotated[int, BeforeValidator(_duration)]
Period = Annotated[int, BeforeValidator(_period)]
Entries = dict[str, Any]  # read one by one afterwards, so that one wrong entry does not hide the others


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class Settings(_Part):
    """The top level; times in ns."""

    name: Annotated[str, AfterValidator(_name)] | None = Field(None, description="names the log")
    description: str = ""
    duration: Duration = Field(description="simulated time, such as '10 s'")
    step: Period = Field(description="the base step, such as '20 ms'")
    seed: Annotated[int, Field(ge=0, lt=2**64)] = 0
    start: Start = 0
    bus: Literal["local", "zenoh"] = "local"
    scene: Annotated[int | None, BeforeValidator(_scene)] = 40_000_000  # 25 Hz, a film's rate
    components: Annotated[Entries, Field(min_length=1)] = Field(description="a mapping of names to components")
    bonds: Entries = {}
    hosts: Entries = {}
    machines: Entries = {}
    events: list[Any] = []


class ComponentEntry(_Part):
    """One component: a model, or an FMU and how it is run."""

    model: str | None = None
    fmu: str | None = None
    interface: Literal["co-simulation", "model-exchange"] | None = None
    isolate: bool | None = None
    period: Period | None = None
    parameters: Entries = {}
    inputs: Entries = {}
    record: Annotated[Record, BeforeValidator(_record)] = Record()
    overdue: Duration | None = Field(None, description="wall time that a step may take on another host, such as '1 s'")


class SignalEntry(_Part):
    """`{from: a.force, gain: 2, delay: true}`: gain, offset and initial are read with the signal's unit later."""

    source: str = Field(alias="from", description="a signal such as hand.motion")
    gain: Any = None
    offset: Any = None
    delay: bool = False
    initial: Any = None


class SumEntry(_Part):
    """`{sum: [a.force, b.force]}`."""

    sum: Annotated[list[Any], Field(min_length=1)]


class BondEntry(_Part):
    """A power bond between a body and a line.

    tolerance: where accepted force and law differ by more, the step is repeated; 1 mN is below what load cells
    resolve. rounds: at most so many passes; three were enough for a body of a twentieth of the line's mass, and a
    bond that needs more than eight does not converge.
    """

    body: str = Field(description="a body's end such as ball.hook")
    line: str = Field(description="a line's end such as tether.end_b")
    tolerance: Annotated[float, BeforeValidator(_newton)] = 1e-3
    rounds: Annotated[int, Field(ge=1, le=100)] = 8


class MachineEntry(_Part):
    """A host that is not a process of this machine; limit: wall time that the run waits for it to answer."""

    limit: Duration = 30_000_000_000


class EventEntry(_Part):
    """What happens at one time; `until` ends what `add` adds."""

    at: Time = Field(description="a simulated time such as '10 s'")
    set: Entries = {}
    add: Entries = {}
    until: Time | None = None


Part = TypeVar("Part", bound=_Part)


def validated(kind: type[Part], tree: Tree, path: str, problems: list[Problem]) -> Part | None:
    """The part read from the tree, or None with its problems added."""
    if not isinstance(tree, Table):
        problems.append(Problem(tree.place, path, f"{_of_kind(plain(tree))} where a mapping is expected"))
        return None
    try:
        return kind.model_validate(plain(tree))
    except ValidationError as error:
        names = [field.alias or name for name, field in kind.model_fields.items()]
        about = {field.alias or name: field.description or "" for name, field in kind.model_fields.items()}
        for detail in error.errors(include_url=False):
            problems.append(_problem(detail, tree, path, names, about))
        return None


def limited(problems: list[Problem], most: int = 100) -> list[Problem]:
    """The first of very many problems, and their number; nobody reads a hundred thousand lines."""
    if len(problems) <= most:
        return problems
    kept = sorted(problems, key=lambda problem: problem.place)[:most]
    return [*kept, Problem(kept[-1].place, "", f"and {len(problems) - most} problems more")]


def below(path: str, *steps: str | int) -> str:
    """The path of something inside: `components.tether`, `events[2]`."""
    for step in steps:
        path += f"[{step}]" if isinstance(step, int) else f".{step}" if path else step
    return path


def place_at(tree: Tree, steps: tuple[str | int, ...], *, key: bool = False) -> Place:
    """Where a value stands (or its key); the deepest that there is."""
    place = tree.place
    for step in steps:
        if isinstance(tree, Table) and step in tree.entries:
            place = tree.keys[str(step)] if key else tree.entries[str(step)].place
            tree = tree.entries[str(step)]
        elif isinstance(tree, Items) and isinstance(step, int) and step < len(tree.items):
            tree = tree.items[step]
            place = tree.place
        else:
            break
    return place


def _problem(detail: ErrorDetails, tree: Table, path: str, names: list[str], about: dict[str, str]) -> Problem:
    steps = detail["loc"]
    name = str(steps[-1]) if steps else ""
    if detail["type"] == "extra_forbidden":
        return Problem(place_at(tree, steps, key=True), below(path, *steps), f"unknown key{closest(name, names)}")
    if detail["type"] == "missing":
        expected = f"; expected {about[name]}" if about.get(name) else ""
        return Problem(tree.place, path, f"the key '{name}' is missing{expected}")
    return Problem(place_at(tree, steps), below(path, *steps), in_words(detail))


_KINDS = {
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "float_type": "a number",
    "bool_type": "true or false",
    "string_type": "text",
    "dict_type": "a mapping",
    "model_type": "a mapping",
    "list_type": "a list",
    "tuple_type": "a list",
}
_BOUNDS = {
    "greater_than": "above",
    "greater_than_equal": "at least",
    "less_than": "below",
    "less_than_equal": "at most",
}


def in_words(detail: ErrorDetails, unit: str = "") -> str:
    """One of pydantic's findings: what is wrong, and what would be right; bounds are in `unit`."""
    kind, context, value = detail["type"], detail.get("ctx", {}), detail["input"]
    if kind == "value_error":
        return str(context["error"])
    if kind in _KINDS:
        return f"{_of_kind(value)} where {_KINDS[kind]} is expected"
    if kind in _BOUNDS:
        bound = next(iter(context.values()))
        return f"{_number(value)}{unit} is out of range; must be {_BOUNDS[kind]} {_number(bound)}{unit}"
    if kind == "literal_error":
        return f"{shown(value)} is not possible; expected {context['expected']}"
    if kind in ("too_short", "too_long", "string_too_short", "string_too_long"):
        bound = context.get("min_length", context.get("max_length"))
        what = "letters" if kind.startswith("string") else "entries"
        if "short" in kind:
            return "empty" if bound == 1 else f"too short; expected at least {bound} {what}"
        return f"too long; expected at most {bound} {what}"
    if kind == "finite_number":
        return f"{shown(value)} is not finite; expected a finite number"
    return detail["msg"].removeprefix("Value error, ").removeprefix("Assertion failed, ")


def _number(value: object) -> str:
    """Without the .0 that pydantic gives a whole number."""
    return f"{value:.12g}" if isinstance(value, float) else shown(value)


def _of_kind(value: object) -> str:
    if isinstance(value, dict):
        return "a mapping"
    return "a list" if isinstance(value, list | tuple) else shown(value)
