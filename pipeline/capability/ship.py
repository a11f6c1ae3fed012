"""A ship file: thrusters, the loads on the ship, and which failures are to be looked at."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from components.allocator.exact.model import Exact
from components.contract import Parameters
from components.vessel.low_speed.model import LowSpeed
from pipeline import parameters
from pipeline.capability.loads import Loads, read_loads
from pipeline.capability.weather import Weather, mismatch, standing_loads
from pipeline.catalogue import closest
from pipeline.document import below
from pipeline.errors import Place, Problem, ScenarioError
from pipeline.parameters import Given
from pipeline.yaml_source import Items, Scalar, Table, Tree, parse, plain, read_text

KEYS = ("name", "loads", "vessel", "weather", "thrusters", "names", "switchboards", "failures", "weights")
# Keys of the DP Capability Tool's files, whose numbers have no units: the parameter's name and the unit.
PUBLISHED = {
    "type": ("kind", ""),
    "thrust": ("max_thrust", "kN"),
    "power": ("max_power", "kW"),
    "forbidden_deg": ("forbidden", "deg"),
    "x": ("x", "m"),
    "y": ("y", "m"),
}

# What loads are made of where there is no table of them.
COEFFICIENTS: tuple[tuple[type[Parameters], str], ...] = ((LowSpeed, "vessel"), (Weather, "weather"))


@dataclass(frozen=True)
class Ship:
    """names: of the thrusters. failures: {case: names of the thrusters lost}, in the order of the file."""

    names: list[str]
    allocator: Exact
    loads: Loads
    failures: Mapping[str, frozenset[str]]

    def left_after(self, lost: frozenset[str]) -> list[bool]:
        """Which thrusters can still be used."""
        return [name not in lost for name in self.names]


def read_ship(path: Path) -> Ship:
    """Raises ScenarioError with all problems of the file, or TowlineError for its table of loads."""
    tree, problems = parse(read_text(path, str(path)), str(path))
    if tree is not None and not isinstance(tree, Table):
        problems.append(Problem(tree.place, "", "expected a mapping with thrusters, and loads or vessel and weather"))
    if not isinstance(tree, Table):
        raise ScenarioError(problems)
    for key in tree.entries.keys() - set(KEYS):
        problems.append(Problem(tree.keys[key], key, f"unknown key{closest(key, list(KEYS))}"))
    names, allocator = _allocator(tree, path.parent, problems)
    failures = _failures(tree, names, problems)
    loads = _loads(tree, path.parent, problems)
    if problems or allocator is None or loads is None:
        raise ScenarioError(problems)
    return Ship(names, allocator, loads(), failures)


def _loads(tree: Table, folder: Path, problems: list[Problem]) -> Callable[[], Loads] | None:
    """What gives the loads: a table's path, or a vessel's coefficients and the weather."""
    if "vessel" in tree.entries or "weather" in tree.entries:
        if "loads" in tree.entries:
            text = "given beside vessel and weather; keep the table or these"
            problems.append(Problem(tree.keys["loads"], "loads", text))
        vessel, weather = (_parameters(kind, tree, key, folder, problems) for kind, key in COEFFICIENTS)
        if vessel is None or weather is None:
            return None
        lacking = mismatch(vessel, weather)
        if lacking:
            problems.append(Problem(tree.keys["vessel"], "vessel", lacking))
        return lambda: standing_loads(vessel, weather)
    value = tree.entries.get("loads")
    if isinstance(value, Scalar) and isinstance(value.value, str):
        path = folder / value.value
        return lambda: read_loads(path)
    text = "missing: expected the path of a CSV file, or vessel and weather" if value is None else "no path"
    problems.append(Problem(tree.place if value is None else value.place, "loads", text))
    return None


def _parameters(kind: type[Parameters], tree: Table, key: str, folder: Path, problems: list[Problem]) -> Any:
    """The mapping at a key as parameters, those of files it names included; None with the problems added."""
    value = tree.entries.get(key)
    if not isinstance(value, Table):
        place = tree.place if value is None else value.place
        problems.append(Problem(place, key, "expected a mapping of parameters" if value else "missing"))
        return None
    return parameters.build(kind, parameters.gather(kind, value, folder, key, problems), value.place, key, problems)


def _allocator(tree: Table, folder: Path, problems: list[Problem]) -> tuple[list[str], Exact | None]:
    items = _thrusters(tree, folder, problems)
    if items is None:
        return [], None
    called = _names(tree, len(items.items), problems)
    names, rows = [], []
    for i, item in enumerate(items.items):
        names.append(_name(item, called[i], i, names, problems))
        rows.append(_with_units(item))
    given = {"thrusters": Given(Items(tuple(rows), items.place), tree.keys["thrusters"], folder)}
    if "weights" in tree.entries:
        given["weights"] = Given(tree.entries["weights"], tree.keys["weights"], folder)
    if "switchboards" in tree.entries:
        boards = _switchboards(tree.entries["switchboards"], names, problems)
        given["switchboards"] = Given(boards, tree.keys["switchboards"], folder)
    return names, parameters.build(Exact, given, tree.place, "", problems)


def _thrusters(tree: Table, folder: Path, problems: list[Problem]) -> Items | None:
    """The list of thrusters, or that of the file which `{file: path}` names, such as an allocator's parameters."""
    value = tree.entries.get("thrusters")
    if isinstance(value, Table) and list(value.entries) == ["file"]:
        name = plain(value.entries["file"])
        if isinstance(name, str):
            try:
                read, found = parse(read_text(folder / name, name), name)
            except ScenarioError as error:
                problems.append(Problem(value.place, "thrusters.file", f"{name}: {error.problems[0].text}"))
                return None
            problems.extend(found)
            value = read.entries.get("thrusters", read) if isinstance(read, Table) else read
    if isinstance(value, Items):
        return value
    text = "expected a list of thrusters, or {file: parameters.yaml} with one"
    problems.append(Problem(tree.place if value is None else value.place, "thrusters", text))
    return None


def _names(tree: Table, count: int, problems: list[Problem]) -> list[str]:
    """What `names` calls the thrusters, in their order; else their numbers."""
    value = tree.entries.get("names")
    given = plain(value) if value is not None else None
    if value is not None and not (isinstance(given, list) and len(given) == count):
        problems.append(Problem(value.place, "names", f"expected a list of {count} names, one for each thruster"))
        given = None
    return [str(one) for one in (given if isinstance(given, list) else range(1, count + 1))]


def _switchboards(value: Tree, names: list[str], problems: list[Problem]) -> Tree:
    """The list of switchboards with their thrusters' names as places in the list of thrusters."""
    if not isinstance(value, Items):
        problems.append(
            Problem(value.place, "switchboards", "expected a list of {thrusters: [Th1], spare_power: 5 MW}")
        )
        return Items((), value.place)
    found: list[Tree] = []
    for b, board in enumerate(value.items):
        fed = board.entries.get("thrusters") if isinstance(board, Table) else None
        if not isinstance(board, Table) or not isinstance(fed, Items):
            problems.append(
                Problem(board.place, below("switchboards", b), "expected {thrusters: [Th1], spare_power: 5 MW}")
            )
            continue
        places: list[Tree] = []
        for item in fed.items:
            name = str(plain(item))
            if name in names:
                places.append(Scalar(names.index(name), item.place))
            else:
                text = f"'{name}' is no thruster{closest(name, names)}"
                problems.append(Problem(item.place, below("switchboards", b, "thrusters"), text))
        if len(places) == len(fed.items):
            entries = {**board.entries, "thrusters": Items(tuple(places), fed.place)}
            found.append(Table(entries, board.keys, board.place))
    return Items(tuple(found), value.place)


def _name(item: Tree, called: str, i: int, before: list[str], problems: list[Problem]) -> str:
    """A thruster's own name, or what it is called where it has none."""
    name = str(plain(item.entries["name"])) if isinstance(item, Table) and "name" in item.entries else called
    if name in before:
        problems.append(Problem(item.place, below("thrusters", i, "name"), f"'{name}' is another thruster's name"))
    return name


def _with_units(item: Tree) -> Tree:
    """A thruster's mapping under the parameters' names, with units where a published file has none."""
    if not isinstance(item, Table):
        return item
    entries: dict[str, Tree] = {}
    keys: dict[str, Place] = {}
    for key, value in item.entries.items():
        name, unit = PUBLISHED.get(key, (key, ""))
        if key != "name":
            entries[name], keys[name] = _unit_given(value, unit), item.keys[key]
    return Table(entries, keys, item.place)


def _unit_given(value: Tree, unit: str) -> Tree:
    if isinstance(value, Items):
        return Items(tuple(_unit_given(item, unit) for item in value.items), value.place)
    if not unit or not isinstance(value, Scalar) or isinstance(value.value, str | bool | None):
        return value
    return Scalar(f"{value.value!r} {unit}", value.place)


def _failures(tree: Table, names: list[str], problems: list[Problem]) -> dict[str, frozenset[str]]:
    """What the file names, each a list of thrusters that fail together (a switchboard's); else each thruster alone."""
    table = tree.entries.get("failures")
    if table is None:
        return {name: frozenset([name]) for name in names}
    if not isinstance(table, Table):
        text = "expected a mapping such as {switchboard A: [Th1, Th3]}"
        problems.append(Problem(table.place, "failures", text))
        return {}
    found = {}
    for case, value in table.entries.items():
        lost = plain(value) if isinstance(value, Items) else [plain(value)]
        for name in lost if isinstance(lost, list) else []:
            if str(name) not in names:
                text = f"'{name}' is no thruster{closest(str(name), names)}"
                problems.append(Problem(value.place, below("failures", case), text))
        found[case] = frozenset(map(str, lost)) if isinstance(lost, list) else frozenset()
    return found
