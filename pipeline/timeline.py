"""Events of a scenario made into the graph's: times into ticks, names into indices, values into SI."""

from __future__ import annotations

from collections.abc import Mapping, Set
from typing import Any

from components.contract import Component, Parameters
from pipeline import parameters
from pipeline.catalogue import closest, first_line
from pipeline.errors import Problem
from pipeline.graph import Event
from pipeline.parameters import Given
from pipeline.quantities import as_time, shown
from pipeline.signals import locate, runs
from pipeline.wires import Draft, array
from pipeline.written import Change, Happening, Scenario
from pipeline.yaml_source import plain


def events(
    scenario: Scenario, drafts: Mapping[str, Draft], broken: Set[str], ticks: int, problems: list[Problem]
) -> tuple[Event, ...]:
    """Events in order of time, ties as in the YAML; a parameter's value is checked with those set before it."""
    line = _Timeline(scenario, drafts, broken, ticks, problems)
    return tuple(line.event(happening) for happening in sorted(scenario.happenings, key=lambda one: one.at_ns))


class _Timeline:
    def __init__(
        self, scenario: Scenario, drafts: Mapping[str, Draft], broken: Set[str], ticks: int, problems: list[Problem]
    ):
        self._scenario, self._drafts, self._ticks, self._problems = scenario, drafts, ticks, problems
        self._broken = broken
        self._now: dict[str, Parameters] = {name: draft.instance.parameters for name, draft in drafts.items()}

    def event(self, happening: Happening) -> Event:
        """One event; worth something only where no problem was found."""
        tick = self._tick(happening, happening.at_ns, "at")
        if self._ticks and tick >= self._ticks:
            end = as_time(self._scenario.start_ns + self._scenario.duration_ns)
            self._report(happening, "at", f"{as_time(happening.at_ns)} is not before the end of the run, {end}")
        until = -1
        if happening.until_ns is not None:
            until = self._tick(happening, happening.until_ns, "until")
            if until <= tick:
                self._report(
                    happening, "until", f"{as_time(happening.until_ns)} is not after 'at'; expected a later time"
                )
            if not happening.adds:
                self._report(happening, "until", "ends nothing; it goes with add")
        sets: dict[int, dict[str, Any]] = {}
        for change in happening.sets:
            self._set(change, sets)
        adds = [add for change in happening.adds for add in self._add(change)]
        return Event(tick, tuple(sets.items()), tuple(adds), until, _text(happening))

    def _report(self, happening: Happening, key: str, text: str) -> None:
        self._problems.append(Problem(happening.places[key], f"{happening.path}.{key}", text))

    def _tick(self, happening: Happening, time_ns: int, key: str) -> int:
        """The tick that starts at the time."""
        step, start = self._scenario.step_ns, self._scenario.start_ns
        if not step:
            return 0
        tick, rest = divmod(time_ns - start, step)
        if tick < 0:
            self._report(happening, key, f"{as_time(time_ns)} is before the start of the run, {as_time(start)}")
        elif rest:
            nearest = as_time(start + (tick + (2 * rest >= step)) * step)
            text = f"{as_time(time_ns)} does not begin a step of {as_time(step)}; nearest is {nearest}"
            self._report(happening, key, text)
        return tick

    def _draft(self, change: Change) -> Draft | None:
        name = change.what.component
        if name not in self._drafts and name not in self._broken:
            text = f"unknown component '{name}'{closest(name, list(self._drafts))}"
            self._problems.append(Problem(change.key, change.path, text))
        return self._drafts.get(name)

    def _set(self, change: Change, sets: dict[int, dict[str, Any]]) -> None:
        draft, name = self._draft(change), change.what.port
        if draft is None:
            return
        kind = draft.instance.component.parameters
        tunable = [field for field in kind.model_fields if parameters.is_tunable(kind, field)]
        if name not in tunable or change.what.slice is not None:
            what = "is fixed during a run" if name in kind.model_fields else "is no parameter"
            text = f"'{change.what}' {what}{closest(name, tunable, 'a tunable one:')}"
            self._problems.append(Problem(change.key, change.path, text))
            return
        given = Given(change.value, change.key, self._scenario.folder)
        new = parameters.changed(self._now[draft.name], name, given, change.path, self._problems)
        if new is not None and (fault := _relaid(draft.instance.component, self._now[draft.name], new)):
            self._problems.append(Problem(change.key, change.path, f"'{change.what}' {fault}"))
        elif new is not None:
            self._now[draft.name] = new
            sets.setdefault(draft.index, {})[name] = getattr(new, name)

    def _add(self, change: Change) -> list[tuple[int, tuple[float, ...]]]:
        draft = self._draft(change)
        if draft is None:
            return []
        what = change.what
        try:
            found = locate(draft.name, draft.outputs, draft.start, what.port, what.slice, kind="output")
        except ValueError as error:
            self._problems.append(Problem(change.key, change.path, str(error)))
            return []
        if "" not in found:
            text = f"{what} is a bundle; expected one of its ports: {', '.join(found)}"
            self._problems.append(Problem(change.key, change.path, text))
            return []
        signal = found[""]
        if signal.words:
            self._problems.append(Problem(change.key, change.path, f"{what} is an image; nothing can be added to it"))
            return []
        values = array(change.value, signal.unit, signal.shape, change.path, self._problems)
        return [(first, values[at : at + count]) for at, first, count in runs(signal.indices) if values]


def _relaid(kind: Component, before: Parameters, after: Parameters) -> str:
    """What keeps a component that is set up with these parameters from going on with those; empty: nothing."""
    try:
        layouts = [
            (tuple(kind.inputs(values)), tuple(kind.outputs(values)), kind.sizes(values), len(kind.pack(values)))
            for values in (before, after)
        ]
    except Exception as error:  # a third party's code
        return f"cannot take this value: {first_line(error)}"
    if layouts[0] == layouts[1]:
        return ""
    return (
        f"turns a term of {kind.name} on or off that has a place of its own in it, which is fixed during a run; "
        "begin with a very small value instead of none, or end with it"
    )


def _text(happening: Happening) -> str:
    """The event as written, on one line."""
    sets = [f"set {change.what} = {shown(plain(change.value))}" for change in happening.sets]
    adds = [f"add {shown(plain(change.value))} to {change.what}" for change in happening.adds]
    return ", ".join(sets + adds)
