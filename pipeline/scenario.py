"""A scenario: the YAML read and checked, every problem with its file, line and column."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from components.contract import Component, Parameters
from pipeline import catalogue, parameters, signals, wiring
from pipeline.document import (
    IDENTIFIER,
    NOT_A_NAME,
    BondEntry,
    ComponentEntry,
    EventEntry,
    Settings,
    SignalEntry,
    SumEntry,
    below,
    limited,
    name_from,
    place_at,
    validated,
)
from pipeline.errors import Place, Problem, ScenarioError, TowlineError
from pipeline.hosts.fmu.component import component_of
from pipeline.parameters import Given
from pipeline.placement import read_hosts
from pipeline.quantities import nanoseconds, shown
from pipeline.signals import Reference, port_and_slice
from pipeline.written import Addend, Change, Happening, Instance, Scenario, Tie, Wire
from pipeline.yaml_source import Items, Scalar, Table, Tree, parse, plain, read_text

STRUCTURES = (".ssp", ".ssd", ".xml")  # what other tools call systems of FMUs


def load_scenario(path: str | Path, overrides: Sequence[str] = (), duration: str | None = None) -> Scenario:
    """Read a scenario file.

    overrides: `component.parameter=value`, over what the file says; a bare number is SI.
    duration: instead of the file's (`10 s`; a bare number is in seconds); events at or after its end are left out.
    Raises ScenarioError with all problems of the file.
    """
    path = Path(path)
    if path.suffix.lower() in STRUCTURES:
        remedy = f"towline convert {path} -o {path.with_suffix('.yaml').name}"
        raise ScenarioError([Problem(Place(str(path)), "", f"a system structure; make a scenario of it: {remedy}")])
    text = read_text(path, str(path))
    return load_scenario_text(text, str(path), path.absolute().parent, overrides, duration)


def load_scenario_text(
    text: str, source_name: str, folder: str | Path, overrides: Sequence[str] = (), duration: str | None = None
) -> Scenario:
    """As load_scenario, from text; relative paths in it are relative to `folder`."""
    tree, problems = parse(text, source_name)
    if tree is None:
        raise ScenarioError(problems)
    reading = _Reading(source_name, Path(folder), overrides, duration, problems)
    scenario = reading.scenario(tree)
    if scenario is not None and problems:
        problems.extend(wiring.problems_of(scenario))
    if scenario is None or problems:
        raise ScenarioError(limited(problems))
    return scenario


class _Reading:
    """One pass over the tree, gathering problems instead of stopping at the first."""

    def __init__(
        self, source: str, folder: Path, overrides: Sequence[str], duration: str | None, problems: list[Problem]
    ):
        self._source, self._folder, self._problems = source, folder, problems
        self._overrides: dict[str, dict[str, Given]] = {}
        for text in overrides:
            self._override(text)
        self._duration = None if duration is None else self._limit(duration)

    def scenario(self, tree: Tree) -> Scenario | None:
        """The scenario, as far as it can be read; None where not even its top level is a mapping."""
        if not isinstance(tree, Table):
            text = "expected a mapping with duration, step and components"
            self._problems.append(Problem(tree.place, "", text))
            return None
        settings = validated(Settings, tree, "", self._problems)
        tables = {key: _table(tree, key) for key in ("components", "bonds")}
        ties = [self._tie(name, entry) for name, entry in tables["bonds"].entries.items()]
        ends = [tie for tie in ties if tie is not None]
        instances = {name: self._instance(name, tables["components"], ends) for name in tables["components"].entries}
        for name in self._overrides.keys() - instances.keys():
            text = f"unknown component '{name}'{catalogue.closest(name, list(instances))}"
            self._problems.append(Problem(Place("--set"), name, text))
        duration = self._duration or (settings.duration if settings else 0)
        start = settings.start if settings else 0
        happenings = self._happenings(tree, start + self._duration if self._duration else None)
        return Scenario(
            name=settings.name if settings and settings.name else name_from(Path(self._source).stem),
            description=settings.description if settings else "",
            source=self._source,
            folder=self._folder,
            duration_ns=duration,
            step_ns=settings.step if settings else 0,
            start_ns=start,
            seed=settings.seed if settings else 0,
            bus=settings.bus if settings else "local",
            hosts=read_hosts(tree, list(instances), self._problems),
            scene_ns=settings.scene if settings else None,
            instances=tuple(instance for instance in instances.values() if instance is not None),
            ties=tuple(ends),
            happenings=happenings,
            tree=tree,
            limit=place_at(tree, ("duration",)) if self._duration is None else Place("--until"),
            unread=frozenset(tables["bonds"].entries) - {tie.name for tie in ends},
            broken=frozenset(name for name, instance in instances.items() if instance is None),
        )

    def _instance(self, name: str, table: Table, ties: list[Tie]) -> Instance | None:
        tree, place, path = table.entries[name], table.keys[name], below("components", name)
        before = len(self._problems)
        if not IDENTIFIER.fullmatch(name):
            self._problems.append(Problem(place, path, NOT_A_NAME))
        entry = validated(ComponentEntry, tree, path, self._problems)
        if not isinstance(tree, Table):
            return None
        wires = self._wires(_table(tree, "inputs"), below(path, "inputs"))
        found = self._component(tree, path, (entry and entry.overdue) or 0)
        if found is None:
            return None
        full_name, component = found
        values = self._parameters(name, component, tree, place, path, ties)
        if values is None or entry is None or len(self._problems) > before:
            return None
        period, record, overdue = entry.period or 0, entry.record, entry.overdue or 0
        blamed = parameters.last_given(self._overrides.get(name, {}), place)
        return Instance(name, place, path, full_name, component, values, period, record, wires, tree, blamed, overdue)

    def _component(self, tree: Table, path: str, overdue_ns: int) -> tuple[str, Component] | None:
        """The model or FMU that an entry names, and its full name; None where it names none, which is reported."""
        named = [key for key in ("model", "fmu") if key in tree.entries]
        if len(named) != 1:
            text = (
                "the key 'model' is missing; expected a model such as motion.hand or ./my_component.py, or fmu: a file"
            )
            if named:
                text = "both a model and an FMU; keep one of them"
            self._problems.append(Problem(tree.place, path, text))
            return None
        which = tree.entries[named[0]]
        for key in ("interface", "isolate"):
            if key in tree.entries and named != ["fmu"]:
                self._problems.append(Problem(tree.keys[key], below(path, key), "is for FMUs; leave it out"))
        if not isinstance(which, Scalar) or not isinstance(which.value, str):
            return None
        try:
            if named == ["model"]:
                return catalogue.find(which.value, self._folder)
            return self._fmu(which.value, tree, overdue_ns)
        except (ValueError, TowlineError) as error:
            self._problems.append(Problem(which.place, below(path, named[0]), str(error)))
            return None

    def _fmu(self, name: str, tree: Table, overdue_ns: int) -> tuple[str, Component]:
        """Raises TowlineError."""
        interface, isolate = (tree.entries.get(key) for key in ("interface", "isolate"))
        wanted = str(interface.value) if isinstance(interface, Scalar) and interface.value is not None else ""
        is_reference = "#" in name and not name.endswith(".fmu")
        path = self._built(name) if is_reference else (self._folder / name).absolute()
        is_apart = isinstance(isolate, Scalar) and isolate.value is True
        return str(path), component_of(path, wanted, isolate=is_apart, overdue_s=overdue_ns / 1e9)

    def _built(self, reference: str) -> Path:
        """The FMU of a component of another scenario. Raises TowlineError."""
        from pipeline.fmu.cached import cached_fmu  # which reads scenarios itself

        return cached_fmu(self._folder, reference)

    def _parameters(
        self, name: str, component: Component, tree: Table, place: Place, path: str, ties: list[Tie]
    ) -> Parameters | None:
        kind, inside = component.parameters, below(path, "parameters")
        table, before = _table(tree, "parameters"), len(self._problems)
        given = parameters.gather(kind, table, self._folder, inside, self._problems)
        unread = len(self._problems) > before and parameters.FILE in table.entries
        is_table = isinstance(tree.entries.get("parameters", table), Table)
        keys = parameters.keys(kind)
        meant = catalogue.meant(table.entries.keys() - set(keys), keys)
        if unread or not is_table or parameters.FILE in meant - kind.model_fields.keys():
            meant = frozenset(kind.model_fields)
        for key, value in self._overrides.get(name, {}).items():
            if key in kind.model_fields:
                given[key] = value
            else:
                text = f"unknown parameter{catalogue.closest(key, list(kind.model_fields))}"
                self._problems.append(Problem(value.key, f"{name}.{key}", text))
        for tie in ties:
            ends = ((tie.line, component.lines), (tie.body, component.bodies))
            tied = [known[at.port] for at, known in ends if at.component == name and at.port in known]
            for switch in (end.switch for end in tied if end.switch):
                self._switch_on(switch, tie, given, inside)
        where = tree.keys.get("parameters", place)
        return parameters.build(kind, given, where, inside, self._problems, meant - given.keys())

    def _switch_on(self, switch: str, tie: Tie, given: dict[str, Given], path: str) -> None:
        """Set the parameter by which an end knows of its bond; what is written must not say otherwise."""
        written = given.get(switch)
        if written is not None and plain(written.tree) is not True:
            text = (
                f"{shown(plain(written.tree))}, but bond '{tie.name}' turns it on; leave it out, or leave out the bond"
            )
            self._problems.append(Problem(written.tree.place, below(path, switch), text))
        given[switch] = Given(Scalar(True, tie.place), tie.place, self._folder)

    def _wires(self, table: Table, path: str) -> tuple[Wire, ...]:
        wires = []
        for key, tree in table.entries.items():
            inside = below(path, key)
            try:
                port, part = port_and_slice(key)
            except ValueError as error:
                self._problems.append(Problem(table.keys[key], inside, str(error)))
                continue
            wires.append(Wire(table.keys[key], inside, port, part, self._addends(tree, inside)))
        return tuple(wires)

    def _addends(self, tree: Tree, path: str) -> tuple[Addend, ...]:
        if isinstance(tree, Table) and "sum" in tree.entries:
            entry = validated(SumEntry, tree, path, self._problems)
            terms = tree.entries["sum"]
            if entry is None or not isinstance(terms, Items):
                return ()
            return tuple(
                addend for i, term in enumerate(terms.items) for addend in self._addend(term, below(path, "sum", i))
            )
        if isinstance(tree, Scalar) and tree.value is None:
            text = "nothing is wired; expected a signal such as hand.motion, or a constant"
            self._problems.append(Problem(tree.place, path, text))
            return ()
        return self._addend(tree, path)

    def _addend(self, tree: Tree, path: str) -> tuple[Addend, ...]:
        """One addend, or none with a problem added."""
        if isinstance(tree, Table) and set(tree.entries) != {"values", "unit"}:
            entry = validated(SignalEntry, tree, path, self._problems)
            source = self._reference(entry.source, tree.entries["from"].place, path, signals.source) if entry else None
            if entry is None or source is None:
                return ()
            extra = {key: tree.entries.get(key) for key in ("gain", "offset", "initial")}
            return (Addend(tree.place, path, source, delayed=entry.delay, **extra),)
        if isinstance(tree, Scalar) and isinstance(tree.value, str) and tree.value[:1].isalpha():
            source = self._reference(tree.value, tree.place, path, signals.source)
            return (Addend(tree.place, path, source),) if source else ()
        return (Addend(tree.place, path, offset=tree),)

    def _reference(
        self, text: str, place: Place, path: str, parse: Callable[[str], Reference] = signals.reference
    ) -> Reference | None:
        try:
            return parse(text)
        except ValueError as error:
            self._problems.append(Problem(place, path, str(error)))
            return None

    def _tie(self, name: str, tree: Tree) -> Tie | None:
        path = below("bonds", name)
        if not IDENTIFIER.fullmatch(name):
            self._problems.append(Problem(tree.place, path, NOT_A_NAME))
        entry = validated(BondEntry, tree, path, self._problems)
        if entry is None or not isinstance(tree, Table):
            return None
        body = self._reference(entry.body, tree.entries["body"].place, below(path, "body"))
        line = self._reference(entry.line, tree.entries["line"].place, below(path, "line"))
        if body is None or line is None:
            return None
        places = {key: tree.entries[key].place for key in ("body", "line")}
        for key, end in (("body", body), ("line", line)):
            if end.slice is not None:
                text = f"'{end}' is a slice; expected an end such as {end.component}.{end.port}"
                self._problems.append(Problem(places[key], below(path, key), text))
        return Tie(name, tree.place, path, body, line, entry.tolerance, entry.rounds, places)

    def _happenings(self, tree: Table, end_ns: int | None) -> tuple[Happening, ...]:
        events = tree.entries.get("events")
        if not isinstance(events, Items):
            return ()
        read = [self._happening(event, below("events", i)) for i, event in enumerate(events.items)]
        return tuple(event for event in read if event is not None and (end_ns is None or event.at_ns < end_ns))

    def _happening(self, tree: Tree, path: str) -> Happening | None:
        entry = validated(EventEntry, tree, path, self._problems)
        if entry is None or not isinstance(tree, Table):
            return None
        if not entry.set and not entry.add:
            text = "nothing happens; expected set: {component.parameter: value} or add: {component.port: value}"
            self._problems.append(Problem(tree.place, path, text))
        sets = self._changes(_table(tree, "set"), below(path, "set"))
        adds = self._changes(_table(tree, "add"), below(path, "add"))
        places = {key: value.place for key, value in tree.entries.items()}
        return Happening(tree.place, path, entry.at, entry.until, sets, adds, places)

    def _changes(self, table: Table, path: str) -> tuple[Change, ...]:
        changes = []
        for key, value in table.entries.items():
            what = self._reference(key, table.keys[key], below(path, key))
            if what is not None:
                changes.append(Change(table.keys[key], below(path, key), what, value))
        return tuple(changes)

    def _override(self, text: str) -> None:
        place = Place("--set")
        key, equals, value = text.partition("=")
        component, dot, name = key.strip().partition(".")
        if not (equals and dot and value.strip()):
            problem = f"'{text[:80]}' is no override; expected component.parameter=value"
            self._problems.append(Problem(place, "", problem))
            return
        tree, found = parse(value, "--set")
        self._problems.extend(Problem(place, key, problem.text) for problem in found)
        if tree is not None:
            self._overrides.setdefault(component, {})[name] = Given(tree, place, Path.cwd(), is_si=True)

    def _limit(self, text: str) -> int | None:
        try:
            duration = nanoseconds(text, bare=True)
            if duration <= 0:
                raise ValueError(f"'{text}' is not above zero; expected e.g. '10 s'")
        except ValueError as error:
            self._problems.append(Problem(Place("--until"), "", str(error)))
            return None
        return duration


def _table(tree: Table, key: str) -> Table:
    """The mapping under a key; an empty one where there is none (or another kind, which validation reports)."""
    inside = tree.entries.get(key)
    return inside if isinstance(inside, Table) else Table({}, {}, tree.place)
