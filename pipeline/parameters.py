"""A component's parameters from YAML, files of published numbers and CSV tables, in SI."""

from __future__ import annotations

import csv
import io
import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

from pydantic import ValidationError

from components.contract import Parameters
from pipeline.catalogue import closest, first_line
from pipeline.document import below, in_words, place_at
from pipeline.errors import Place, Problem, ScenarioError
from pipeline.quantities import converts, is_plain, si_value
from pipeline.yaml_source import Items, Scalar, Table, Tree, parse, plain, read_text

FILE = "file"  # the key of a file or files of parameters, unless a parameter has that name


@dataclass(frozen=True)
class Given:
    """A value somebody wrote for a parameter.

    unit: what a bare number is in ("": a bare number of a dimensional quantity is an error); is_si: it is in SI, as
    overrides of the command line are.
    folder: what the paths in it are relative to.
    """

    tree: Tree
    key: Place
    folder: Path
    unit: str = ""
    is_si: bool = False


def unit_of(kind: type[Parameters], name: str) -> str | None:
    """The parameter's SI unit; None where it is no quantity."""
    extra = kind.model_fields[name].json_schema_extra
    unit = extra.get("unit") if isinstance(extra, dict) else None
    return unit if isinstance(unit, str) else None


def is_tunable(kind: type[Parameters], name: str) -> bool:
    """Whether an event may change the parameter."""
    extra = kind.model_fields[name].json_schema_extra
    return isinstance(extra, dict) and extra.get("tunable") is True


def nested(kind: type[Parameters], name: str) -> type[Parameters] | None:
    """What a parameter is, or is a list of, where it is a mapping of parameters or a list of such."""
    annotation = kind.model_fields[name].annotation
    found = [one for one in (annotation, *get_args(annotation)) if isinstance(one, type)]
    return next((one for one in found if issubclass(one, Parameters)), None)


def keys(kind: type[Parameters]) -> list[str]:
    """What a scenario may write for a component: its parameters, and the file that gives them."""
    return [*dict.fromkeys((*kind.model_fields, FILE))]


def gather(kind: type[Parameters], table: Table, folder: Path, path: str, problems: list[Problem]) -> dict[str, Given]:
    """What a scenario writes for a component, over what the file or files it names write."""
    given: dict[str, Given] = {}
    if FILE in table.entries and FILE not in kind.model_fields:
        files = table.entries[FILE]
        for one in files.items if isinstance(files, Items) else (files,):
            _from_file(kind, one, folder, below(path, FILE), problems, given)
    for name, tree in table.entries.items():
        if name in kind.model_fields:
            given[name] = Given(tree, table.keys[name], folder)
        elif name != FILE:
            problems.append(
                Problem(table.keys[name], below(path, name), f"unknown parameter{closest(name, keys(kind))}")
            )
    return given


def build(
    kind: type[Parameters],
    given: dict[str, Given],
    place: Place,
    path: str,
    problems: list[Problem],
    meant: frozenset[str] = frozenset(),
) -> Any:
    """The validated parameters (of type `kind`), or None with the problems added.

    meant: parameters that something else wrong was probably meant to give; their lack is not reported.
    """
    before = len(problems)
    values = {name: _value(kind, name, one, below(path, name), problems) for name, one in given.items()}
    wrong = {problem.path for problem in problems[before:]}
    try:
        parameters = kind.model_validate_json(json.dumps(values), strict=True)
    except ValidationError as error:
        for detail in error.errors(include_url=False):
            steps = detail["loc"]
            name = str(steps[0]) if steps else ""
            if name in meant or any(problem.startswith(below(path, *steps[:1])) for problem in wrong):
                continue
            if any(problem == below(path, *steps) for problem in wrong):
                continue
            last, field = _innermost(kind, steps)
            text = _missing(last, field) if detail["type"] == "missing" else in_words(detail, _suffix(last, field))
            where = place if name else last_given(given, place)
            if name in given:
                where = place_at(given[name].tree, steps[1:])
            problems.append(Problem(where, below(path, *steps), text))
        return None
    except Exception as error:  # of a validator, which may be a third party's
        problems.append(Problem(last_given(given, place), path, f"not taken by {kind.__name__}: {first_line(error)}"))
        return None
    return parameters if len(problems) == before else None


def last_given(given: dict[str, Given], place: Place) -> Place:
    """Whom to blame for what the values are together: an override if there is one, else the place of the parameters."""
    return next((one.key for one in given.values() if one.is_si), place)


def changed(parameters: Parameters, name: str, given: Given, path: str, problems: list[Problem]) -> Parameters | None:
    """The parameters with one of them replaced, as an event does."""
    kind, before = type(parameters), len(problems)
    value = _value(kind, name, given, path, problems)
    if len(problems) > before:
        return None
    try:
        values = {**parameters.model_dump(mode="json"), name: value}
        return kind.model_validate_json(json.dumps(values), strict=True)
    except ValidationError as error:
        for detail in error.errors(include_url=False):
            problems.append(Problem(given.tree.place, path, in_words(detail, _suffix(kind, name))))
    except Exception as error:  # of a validator, which may be a third party's
        problems.append(Problem(given.tree.place, path, f"not taken by {kind.__name__}: {first_line(error)}"))
    return None


def written(parameters: Parameters) -> dict[str, Any]:
    """All parameters as plain YAML values with units, which read back to the same bits."""
    found: dict[str, Any] = {}
    for name, value in parameters.model_dump(mode="json").items():
        inner = getattr(parameters, name)
        if isinstance(inner, Parameters):
            found[name] = written(inner)
        elif nested(type(parameters), name) is None or inner is None:
            found[name] = _written(value, unit_of(type(parameters), name))
        else:
            found[name] = [written(one) for one in inner]
    return found


def numbers(tree: Tree, unit: str, path: str, problems: list[Problem], bare: str = "") -> Any:
    """A number or nested lists of numbers in `unit`; `{values: [1, 2], unit: m}` gives one unit to all.

    bare: the unit of numbers without one, if they are allowed. Wrong ones add a problem and count as zero.
    """
    if isinstance(tree, Table):
        return _with_unit(tree, unit, path, problems)
    if isinstance(tree, Items):
        steps = enumerate(tree.items)
        return [numbers(item, unit, below(path, i), problems, bare) for i, item in steps]
    try:
        if bare and bare != unit and isinstance(tree.value, int | float) and not isinstance(tree.value, bool):
            return si_value(f"{tree.value} {bare}", unit)
        value = si_value(tree.value, unit, bare=bool(bare))
        return tree.value if isinstance(tree.value, int) else value
    except ValueError as error:
        problems.append(Problem(tree.place, path, str(error)))
        return 0.0


def _with_unit(tree: Table, unit: str, path: str, problems: list[Problem]) -> Any:
    written_unit = tree.entries.get("unit")
    if set(tree.entries) != {"values", "unit"} or not isinstance(written_unit, Scalar):
        text = f"a mapping where a number in {unit} is expected (or {{values: [...], unit: {unit}}})"
        problems.append(Problem(tree.place, path, text))
        return 0.0
    if not converts(str(written_unit.value), unit):
        text = f"'{written_unit.value}' does not convert to '{unit}'"
        problems.append(Problem(written_unit.place, below(path, "unit"), text))
        return 0.0
    return numbers(tree.entries["values"], unit, below(path, "values"), problems, str(written_unit.value))


def _value(kind: type[Parameters], name: str, given: Given, path: str, problems: list[Problem]) -> Any:
    unit = unit_of(kind, name)
    tree = given.tree
    if isinstance(tree, Table) and "csv" in tree.entries:
        return _rows(tree, given.folder, path, problems)
    inner = nested(kind, name)
    if inner is not None and isinstance(tree, Items):
        steps = enumerate(tree.items)
        return [_mapping(inner, item, given, below(path, i), problems) for i, item in steps]
    if inner is not None and isinstance(tree, Table):
        return _mapping(inner, tree, given, path, problems)
    if unit is None or (isinstance(tree, Scalar) and tree.value is None):
        value = plain(tree)
        if kind.model_fields[name].annotation is Path and isinstance(value, str):
            return str((given.folder / value).resolve())
        return value
    return numbers(tree, unit, path, problems, unit if given.is_si else given.unit)


def _mapping(kind: type[Parameters], tree: Tree, given: Given, path: str, problems: list[Problem]) -> Any:
    """A mapping of parameters, in SI."""
    if not isinstance(tree, Table):
        return plain(tree)
    values = {}
    for name, value in tree.entries.items():
        if name in kind.model_fields:
            one = Given(value, tree.keys[name], given.folder, given.unit, given.is_si)
            values[name] = _value(kind, name, one, below(path, name), problems)
        else:
            text = f"unknown parameter{closest(name, list(kind.model_fields))}"
            problems.append(Problem(tree.keys[name], below(path, name), text))
    return values


def _from_file(
    kind: type[Parameters], tree: Tree, folder: Path, path: str, problems: list[Problem], given: dict[str, Given]
) -> None:
    name = plain(tree)
    if not isinstance(name, str):
        problems.append(Problem(tree.place, path, "expected the path of a YAML file, or a list of such"))
        return
    try:
        table, found = parse(read_text(folder / name, name), name)
    except ScenarioError as error:
        problems.append(Problem(tree.place, path, f"{name}: {error.problems[0].text}"))
        return
    problems.extend(found)
    if not isinstance(table, Table):
        if table is not None:
            problems.append(Problem(table.place, "", "expected a mapping of parameters"))
        return
    for key, value in table.entries.items():
        parameter, unit = _published(kind, key)
        if parameter not in kind.model_fields:
            text = f"unknown parameter{closest(parameter, list(kind.model_fields))}"
            problems.append(Problem(table.keys[key], key, text))
        elif parameter in given:
            problems.append(Problem(table.keys[key], key, f"'{parameter}' is given twice; keep one"))
        else:
            given[parameter] = Given(value, table.keys[key], (folder / name).parent, unit)


def _published(kind: type[Parameters], key: str) -> tuple[str, str]:
    """Parameter and unit of a key such as `wet_mass_kg_per_m`; the key itself where it is no such thing."""
    if key in kind.model_fields:
        return key, ""
    for name in sorted(kind.model_fields, key=len, reverse=True):
        unit, wanted = _spelt(key.removeprefix(f"{name}_")), unit_of(kind, name)
        if key.startswith(f"{name}_") and wanted is not None and converts(unit, wanted):
            return name, unit
    return key, ""


def _spelt(suffix: str) -> str:
    """`kg_per_m` -> `kg/m`, `kg_m2` -> `kg*m^2`, `hz` -> `Hz`."""
    above, *under = [re.sub(r"([A-Za-z])([0-9])", r"\1^\2", part) for part in suffix.split("_per_")]
    unit = "/".join([above.replace("_", "*"), *(part.replace("_", "/") for part in under)])
    return re.sub(r"\bhz\b", "Hz", unit)


def _rows(tree: Table, folder: Path, path: str, problems: list[Problem]) -> Any:
    """The table of `{csv: path, columns: [..]}` as rows of numbers in SI, or one column (`columns: x`) flat."""
    spec = plain(tree)
    assert isinstance(spec, dict)
    name, wanted = spec.get("csv"), spec.get("columns")
    is_list = isinstance(wanted, list) and all(isinstance(one, str) for one in wanted)
    if not isinstance(name, str) or not (wanted is None or isinstance(wanted, str) or is_list) or len(spec) > 2:
        problems.append(Problem(tree.place, path, "expected {csv: file.csv, columns: [time, x, y, z]}"))
        return []
    try:
        lines = list(csv.reader(io.StringIO(read_text(folder / name, name))))
    except ScenarioError as error:
        problems.append(Problem(tree.place, path, f"{name}: {error.problems[0].text}"))
        return []
    except csv.Error as error:
        problems.append(Problem(tree.place, path, f"{name}: not a CSV file: {error}"))
        return []
    header = [cell.strip() for cell in lines[0]] if lines else []
    columns = header if wanted is None else [wanted] if isinstance(wanted, str) else wanted
    for column in columns:
        if column not in header:
            problems.append(
                Problem(tree.place, below(path, "columns"), f"{name} has no column '{column}'{closest(column, header)}")
            )
            return []
    picks = [header.index(column) for column in columns]
    rows = []
    for line, cells in enumerate(lines[1:], 2):
        texts = [cells[pick] if pick < len(cells) else "" for pick in picks]
        try:
            if cells:
                rows.append([si_value(text.strip(), "1") for text in texts])
        except ValueError as error:
            problems.append(Problem(Place(name, line), path, str(error)))
            break
    return [row[0] for row in rows] if isinstance(wanted, str) else rows


def _innermost(kind: type[Parameters], steps: tuple[str | int, ...]) -> tuple[type[Parameters], str]:
    """The mapping that a place in the parameters is in, and the parameter's name there."""
    name = str(steps[0]) if steps else ""
    inner = nested(kind, name) if name in kind.model_fields else None
    within = steps[2:] if len(steps) > 1 and isinstance(steps[1], int) else steps[1:]
    return _innermost(inner, within) if inner is not None and within else (kind, name)


def _missing(kind: type[Parameters], name: str) -> str:
    field, unit = kind.model_fields[name], unit_of(kind, name)
    about = f" ({field.description})" if field.description else ""
    return f"missing parameter{about}; expected a value in {unit}" if unit else f"missing parameter{about}"


def _suffix(kind: type[Parameters], name: str) -> str:
    unit = unit_of(kind, name) if name in kind.model_fields else None
    return "" if unit is None or is_plain(unit) else f" {unit}"


def _written(value: Any, unit: str | None) -> Any:
    if unit is None or value is None or unit == "1":
        return value
    return {"values": value, "unit": unit} if isinstance(value, list) else f"{value!r} {unit}"
