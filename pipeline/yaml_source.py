"""YAML text read into a tree whose every value knows its place: YAML 1.2 core schema, nothing executed.

PyYAML scans; its own resolver (YAML 1.1) reads 6.0e6 as text, 010 as 8, 1:30 as 90 and off as false, so the plain
scalars are resolved here. Tags, merge keys, duplicate keys, exploding or recursive aliases are refused.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from pipeline.errors import Place, Problem, ScenarioError

LARGEST = 10_000_000  # bytes; a table of 100 000 rows still fits
_DEEPEST = 64  # levels of nesting; no scenario needs ten
_ALIASED = 100_000  # values that aliases may add; a billion laughs adds a billion
_BINARY = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f\ufffe\uffff\ud800-\udfff]")


@dataclass(frozen=True)
class Scalar:
    """null, a truth value, a number or text."""

    value: bool | int | float | str | None
    place: Place


@dataclass(frozen=True)
class Items:
    """A list."""

    items: tuple[Tree, ...]
    place: Place


@dataclass(frozen=True)
class Table:
    """A mapping; `keys` holds the place of each key."""

    entries: dict[str, Tree]
    keys: dict[str, Place]
    place: Place


Tree = Scalar | Items | Table


_CORE = (
    ("null", r"(?:~|null|Null|NULL|)\Z", ["~", "n", "N", ""]),
    ("bool", r"(?:true|True|TRUE|false|False|FALSE)\Z", list("tTfF")),
    ("int", r"(?:[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+)\Z", list("-+0123456789")),
    ("float", r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?\Z", list("-+.0123456789")),
    ("float", r"(?:[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN))\Z", list("-+.")),
)
_TAG = "tag:yaml.org,2002:"


def _resolvers(legacy: dict[str, list]) -> dict[str, list]:
    """First character -> [(tag, pattern)], the core schema's before the legacy ones."""
    table: dict[str, list] = {}
    for kind, pattern, first in _CORE:
        for character in first:
            table.setdefault(character, []).append((_TAG + kind, re.compile(pattern)))
    for character, entries in legacy.items():
        table.setdefault(character, []).extend(entries)
    return table


# libyaml is fifty times faster than PyYAML's own scanner; every wheel of PyYAML has it
_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_Dumper: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)


class _CoreLoader(_Loader):
    """Scans events and resolves plain scalars."""

    yaml_implicit_resolvers = _resolvers({})


class CoreDumper(_Dumper):
    """Writes plain values so that they are read back bit for bit, quoting what YAML 1.1 would misread too."""

    yaml_implicit_resolvers = _resolvers(yaml.SafeDumper.yaml_implicit_resolvers)

    def ignore_aliases(self, data: object) -> bool:
        """Equal values are written out, not aliased."""
        return True


def read_text(path: Path, shown: str) -> str:
    """The text of a YAML file. Raises ScenarioError where it cannot be one, with `shown` as the file's name."""

    def refuse(text: str, line: int = 1, column: int = 1) -> ScenarioError:
        return ScenarioError([Problem(Place(shown, line, column), "", text)])

    try:
        if not path.exists():
            raise refuse("no such file")
        if not path.is_file():
            raise refuse("not a file; expected a YAML file")
        if path.stat().st_size > LARGEST:
            raise refuse(f"larger than {LARGEST // 1_000_000} MB; expected a YAML file")
        data = path.read_bytes()
    except (OSError, ValueError) as error:
        raise refuse(f"cannot be read: {getattr(error, 'strerror', None) or error}") from None
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start]
        line, column = before.count(b"\n") + 1, len(before) - before.rfind(b"\n")
        raise refuse("not UTF-8 text; expected a YAML file", line, column) from None


def parse(text: str, shown: str) -> tuple[Tree | None, list[Problem]]:
    """The tree of the text's one document, and what is wrong with it; no tree where the syntax itself is wrong."""
    if binary := _BINARY.search(text):
        line = text.count("\n", 0, binary.start()) + 1
        column = binary.start() - text.rfind("\n", 0, binary.start())
        return None, [Problem(Place(shown, line, column), "", "a control character; expected a YAML text file")]
    return _Reading(shown).read(text)


class _Stop(Exception):
    """The rest of the text cannot be read."""

    def __init__(self, place: Place, text: str):
        self.problem = Problem(place, "", text)


@dataclass
class _Open:
    """A list or mapping being read; a mapping's children are its keys and values in turn."""

    place: Place
    anchor: str | None
    is_table: bool
    children: list[Tree]
    size: int = 1  # values in it, aliases written out


class _Reading:
    """One pass over the events, with an explicit stack: nesting costs no recursion."""

    def __init__(self, shown: str):
        self._shown = shown
        self._problems: list[Problem] = []
        self._open: list[_Open] = []
        self._anchors: dict[str, tuple[Tree, int]] = {}
        self._aliased = 0
        self._root: Tree | None = None

    def read(self, text: str) -> tuple[Tree | None, list[Problem]]:
        loader = _CoreLoader(text)
        try:
            while not isinstance(event := loader.get_event(), yaml.StreamEndEvent):
                self._take(event, loader)
        except _Stop as stop:
            return None, [*self._problems, stop.problem]
        except yaml.MarkedYAMLError as error:
            mark = error.problem_mark or error.context_mark
            place = self._place(mark) if mark else Place(self._shown)
            why = " ".join(filter(None, (error.context, error.problem))) or "not YAML"
            return None, [*self._problems, Problem(place, "", f"not YAML: {why}")]
        except (yaml.YAMLError, RecursionError, ValueError) as error:
            why = str(error).splitlines()[0] if str(error) else "cannot be parsed"
            return None, [*self._problems, Problem(Place(self._shown), "", f"not YAML: {why}")]
        finally:
            loader.dispose()
        if self._root is None:
            return None, [*self._problems, Problem(Place(self._shown), "", "empty; expected a scenario")]
        return self._root, self._problems

    def _place(self, mark: yaml.Mark) -> Place:
        return Place(self._shown, mark.line + 1, mark.column + 1)

    def _take(self, event: yaml.Event, loader: _CoreLoader) -> None:
        place = self._place(event.start_mark)
        if isinstance(event, yaml.DocumentStartEvent) and self._root is not None:
            raise _Stop(place, "a second document; expected one document in a file")
        if isinstance(event, yaml.NodeEvent) and not isinstance(event, yaml.AliasEvent):
            self._check_tag(event, place)
        if isinstance(event, yaml.ScalarEvent):
            self._close(Scalar(self._value(event, loader, place), place), 1, event.anchor)
        elif isinstance(event, yaml.CollectionStartEvent):
            if len(self._open) == _DEEPEST:
                raise _Stop(place, f"nested deeper than {_DEEPEST} levels")
            is_table = isinstance(event, yaml.MappingStartEvent)
            self._open.append(_Open(place, event.anchor, is_table, []))
        elif isinstance(event, yaml.CollectionEndEvent):
            done = self._open.pop()
            tree = self._table(done) if done.is_table else Items(tuple(done.children), done.place)
            self._close(tree, done.size, done.anchor)
        elif isinstance(event, yaml.AliasEvent):
            self._alias(event.anchor, place)

    def _close(self, tree: Tree, size: int, anchor: str | None) -> None:
        """Hand a finished value to the collection around it."""
        if anchor:
            self._anchors[anchor] = (tree, size)
        if self._open:
            self._open[-1].children.append(tree)
            self._open[-1].size += size
        elif self._root is None:
            self._root = tree

    def _alias(self, anchor: str, place: Place) -> None:
        if any(level.anchor == anchor for level in self._open):
            raise _Stop(place, f"*{anchor} contains itself")
        if anchor not in self._anchors:
            raise _Stop(place, f"*{anchor} is not defined above")
        tree, size = self._anchors[anchor]
        self._aliased += size
        if self._aliased > _ALIASED:
            raise _Stop(place, f"aliases expand to more than {_ALIASED} values")
        self._close(tree, size, None)

    def _check_tag(self, event: yaml.NodeEvent, place: Place) -> None:
        tag = getattr(event, "tag", None)
        if tag is not None:
            written = tag.replace(_TAG, "!!")
            self._problems.append(Problem(place, "", f"the tag {written} is not supported; write the plain value"))

    def _value(self, event: yaml.ScalarEvent, loader: _CoreLoader, place: Place) -> bool | int | float | str | None:
        text: str = event.value
        if not event.implicit[0]:
            return text
        kind = loader.resolve(yaml.ScalarNode, text, (True, False)).removeprefix(_TAG)
        if kind == "null":
            return None
        if kind == "bool":
            return text.lower() == "true"
        if kind == "float":
            return float(text.lower().replace(".inf", "inf").replace(".nan", "nan"))
        if kind == "int":
            return self._integer(text, place)
        return text

    def _integer(self, text: str, place: Place) -> int:
        if len(text) > 400:  # beyond any float, and long before int() takes quadratic time
            self._problems.append(Problem(place, "", "an integer of more than 400 digits"))
            return 0
        return int(text, {"0o": 8, "0x": 16}.get(text[:2], 10))

    def _table(self, done: _Open) -> Table:
        entries: dict[str, Tree] = {}
        keys: dict[str, Place] = {}
        for key, value in self._pairs(done):
            name = key.value if isinstance(key.value, str) else _key_text(key)
            if name in entries:
                text = f"duplicate key '{name}', first on line {keys[name].line}; keep one"
                self._problems.append(Problem(key.place, "", text))
            elif name == "<<":
                self._problems.append(Problem(key.place, "", "merge keys are not supported; write the keys out"))
            else:
                entries[name], keys[name] = value, key.place
        return Table(entries, keys, done.place)

    def _pairs(self, done: _Open) -> Iterator[tuple[Scalar, Tree]]:
        for key, value in zip(done.children[::2], done.children[1::2], strict=True):
            if isinstance(key, Scalar):
                yield key, value
            else:
                self._problems.append(Problem(key.place, "", "a key must be a name, not a list or a mapping"))


def _key_text(key: Scalar) -> str:
    """A key that is no text, as text: `4:`, `true:`."""
    return "null" if key.value is None else str(key.value).lower()


def plain(tree: Tree) -> object:
    """The tree's bare values: dict, list, str, int, float, bool, None."""
    if isinstance(tree, Scalar):
        return tree.value
    if isinstance(tree, Items):
        return [plain(item) for item in tree.items]
    return {name: plain(value) for name, value in tree.entries.items()}
