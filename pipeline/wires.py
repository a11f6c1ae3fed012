"""Wires made into terms: each input's numbers traced to the board, with units, shapes and frames checked."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Set
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from components.contract import ImagePort, Port
from pipeline import parameters, schedule
from pipeline.catalogue import closest, meant
from pipeline.document import below
from pipeline.errors import Place, Problem
from pipeline.graph import Term
from pipeline.quantities import ratio, same_unit
from pipeline.signals import Signal, locate, runs
from pipeline.written import Addend, Instance, Tie, Wire
from pipeline.yaml_source import Tree


@dataclass
class Draft:
    """A node while it is being wired."""

    instance: Instance
    index: int
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    start: int  # of its outputs on the board
    terms: list[Term]
    fed_by: list[str]  # for each number of u, the path of its wire; "": none

    @property
    def name(self) -> str:
        """The instance's name."""
        return self.instance.name


@dataclass(frozen=True)
class Edge:
    """A direct wire from one node to another, by index."""

    producer: int
    consumer: int
    wire: Wire
    addend: Addend


class Wires:
    """The wires of one scenario; `edges` gathers the direct ones."""

    def __init__(self, drafts: Mapping[str, Draft], broken: Set[str], problems: list[Problem]):
        """drafts: by name, laid out; broken: names of components that could not be read."""
        self._drafts, self._broken, self._problems = drafts, broken, problems
        self.edges: list[Edge] = []

    def connect(self, consumer: Draft, wire: Wire) -> None:
        """Add the wire's terms to its consumer."""
        try:
            targets = locate(consumer.name, consumer.inputs, 0, wire.port, wire.slice, kind="input")
        except ValueError as error:
            self._report(wire.place, wire.path, consumer.instance.component.absent.get(wire.port, str(error)))
            return
        self._claim(consumer, wire, targets)
        for number, addend in enumerate(wire.addends):
            if number and any(target.words for target in targets.values()):
                self._report(addend.place, addend.path, "images cannot be added; expected one signal")
                break
            terms = self._addend(consumer, wire, addend, targets)
            consumer.terms.extend(replace(term, assigns=number == 0) for term in terms)

    def rest(self, draft: Draft) -> None:
        """Have inputs that nothing feeds hold what their component has them hold."""
        start, defaults = 0, draft.instance.component.defaults(draft.instance.parameters)
        for port in draft.inputs:
            values = defaults.get(port.name, ())
            loose = [i for i in range(len(values)) if not draft.fed_by[start + i]]
            for _, first, count in runs(tuple(loose)):
                draft.terms.append(Term(start + first, 0, count, gain=0.0, offset=values[first : first + count]))
            start += port.size

    def check_wired(self, draft: Draft) -> None:
        """Every input must be fed, all of it."""
        place = draft.instance.tree.keys.get("inputs", draft.instance.place)
        path = below(draft.instance.path, "inputs")
        bundles: dict[str, list[str]] = {}
        for port, loose in self._loose(draft):
            bundle, _, member = port.name.rpartition(".")
            if bundle and loose == port.size:
                bundles.setdefault(bundle, []).append(member)
                continue
            what = f"'{port.name}' is" if loose == port.size else f"{loose} of {port.size} in '{port.name}' are"
            expected = f"{_quantity_of(port.shape, port.unit)}, from a signal or constant"
            if isinstance(port, ImagePort):
                what, expected = f"'{port.name}' is", image_of(port.shape)
            self._report(place, path, f"{what} not wired; expected {expected}")
        for bundle, members in bundles.items():
            self._report(place, path, f"'{bundle}' is not wired; expected a bundle of {', '.join(members)}")

    def _loose(self, draft: Draft) -> Iterator[tuple[Port, int]]:
        """Inputs that are not fed and not meant by a misspelt wire, with the number of loose values."""
        written = [wire.port for wire in draft.instance.wires]
        names = {n for port in draft.inputs for n in (port.name, port.name.rpartition(".")[0])}
        misspelt = meant(set(written) - names, names)
        start, defaults = 0, draft.instance.component.defaults(draft.instance.parameters)
        for port in draft.inputs:
            end = start + (1 if isinstance(port, ImagePort) else port.size)  # an image is fed as a whole
            loose = 0 if port.name in defaults else draft.fed_by[start:end].count("")
            start += port.size
            if loose and not {port.name, port.name.rpartition(".")[0]} & misspelt:
                yield port, loose

    def bundle_start(self, owner: Draft, bundle: str, tie: Tie, *, is_input: bool = False) -> int:
        """First index of a bundle on the board (or in u), all of whose members follow each other."""
        ports, start = (owner.inputs, 0) if is_input else (owner.outputs, owner.start)
        try:
            members = locate(owner.name, ports, start, bundle, None, kind="input" if is_input else "output")
        except ValueError as error:
            self._report(tie.place, tie.path, str(error))
            return 0
        indices = tuple(index for member in members.values() for index in member.indices)
        if len(runs(indices)) != 1:
            self._report(tie.place, tie.path, f"the ports of bundle '{owner.name}.{bundle}' do not follow each other")
        return indices[0] if indices else 0

    def report_cycles(self, drafts: list[Draft]) -> None:
        """One problem for each knot of direct wires."""
        for cycle in schedule.cycles(len(drafts), {(edge.producer, edge.consumer) for edge in self.edges}):
            pairs = set(zip(cycle, cycle[1:] + cycle[:1], strict=True))
            edges = [edge for edge in self.edges if (edge.producer, edge.consumer) in pairs]
            edge = max(
                edges, key=lambda edge: (not edge.addend.path.startswith("bonds."), edge.producer - edge.consumer)
            )
            names = " -> ".join(drafts[node].name for node in [*cycle, cycle[0]])
            remedy = f"delay one of them, such as {{from: {edge.addend.source}, delay: true}} here"
            self._report(edge.addend.place, edge.addend.path, f"a cycle of direct wires, {names}; {remedy}")

    def _report(self, place: Place, path: str, text: str) -> None:
        self._problems.append(Problem(place, path, text))

    def _claim(self, consumer: Draft, wire: Wire, targets: Mapping[str, Signal]) -> None:
        """Note what the wire feeds; no number may be fed twice."""
        others: dict[str, str] = {}
        for target in targets.values():
            for index in target.indices:
                if consumer.fed_by[index]:
                    others.setdefault(consumer.fed_by[index], target.label)
                consumer.fed_by[index] = wire.path
        for path, label in others.items():
            self._report(
                wire.place, wire.path, f"two wires into {label}, which {path} feeds already; keep one, or sum them"
            )

    def _addend(self, consumer: Draft, wire: Wire, addend: Addend, targets: Mapping[str, Signal]) -> list[Term]:
        if addend.source is None:
            return self._constant(addend, targets)
        source = addend.source
        producer = self._drafts.get(source.component)
        if producer is None:
            if source.component not in self._broken:
                text = (
                    f"unknown component '{source.component}'{closest(source.component, [*self._drafts, *self._broken])}"
                )
                self._report(addend.place, addend.path, text)
            return []
        try:
            members = locate(producer.name, producer.outputs, producer.start, source.port, source.slice, kind="output")
        except ValueError as error:
            text = producer.instance.component.absent.get(source.port, str(error))
            self._report(addend.place, addend.path, text)
            return []
        if not addend.delayed:
            self.edges.append(Edge(producer.index, consumer.index, wire, addend))
        return [
            term
            for target, signal in self._paired(addend, targets, members)
            for term in self._terms(addend, target, signal)
        ]

    def _paired(
        self, addend: Addend, targets: Mapping[str, Signal], members: Mapping[str, Signal]
    ) -> list[tuple[Signal, Signal]]:
        """Targets and sources that belong together: port to port, or members of bundles by name."""
        if "" in members and "" not in targets:
            names = ", ".join(targets)
            self._report(addend.place, addend.path, f"{addend.source} is one port; expected a bundle of {names}")
            return []
        if "" in targets and "" not in members:
            names = ", ".join(members)
            self._report(addend.place, addend.path, f"{addend.source} is a bundle; expected one of its ports: {names}")
            return []
        missing = [name for name in targets if name not in members]
        if missing:
            text = f"{addend.source} has no {', '.join(missing)}; it has {', '.join(members)}"
            self._report(addend.place, addend.path, text)
        if "" not in targets and (addend.offset is not None or addend.initial is not None):
            text = "offset and initial go to single ports; wire the members of the bundle one by one"
            self._report(addend.place, addend.path, text)
            return []
        return [(targets[name], members[name]) for name in targets if name in members]

    def _constant(self, addend: Addend, targets: Mapping[str, Signal]) -> list[Term]:
        assert addend.offset is not None
        if "" not in targets:
            text = f"a constant for a bundle; expected a signal, or constants for its ports: {', '.join(targets)}"
            self._report(addend.place, addend.path, text)
            return []
        target = targets[""]
        if target.words:
            text = f"a constant; {target.label} expects {image_of(target.shape)}, from a signal"
            self._report(addend.place, addend.path, text)
            return []
        values = self._array(addend.offset, target.unit, target.shape, addend.path)
        return [
            Term(first, 0, count, gain=0.0, offset=values[position : position + count])
            for position, first, count in runs(target.indices)
            if values
        ]

    def _terms(self, addend: Addend, target: Signal, source: Signal) -> list[Term]:
        if target.words or source.words:
            return self._image(addend, target, source)
        if not self._fits(addend, target, source):
            return []
        gain = self._gain(addend, target, source)
        offset = self._array(addend.offset, target.unit, target.shape, below(addend.path, "offset"))
        initial = self._array(addend.initial, source.unit, source.shape, below(addend.path, "initial"), is_si=True)
        if addend.initial is not None and not addend.delayed:
            text = "initial without delay: true; a direct wire has no use for it"
            self._report(addend.initial.place, below(addend.path, "initial"), text)
        return [
            Term(
                target.indices[position],
                source.indices[position],
                count,
                gain,
                offset[position : position + count],
                addend.delayed,
                initial[position : position + count],
            )
            for position, count in _common_runs(target.indices, source.indices)
        ]

    def _image(self, addend: Addend, target: Signal, source: Signal) -> list[Term]:
        """The pixels as they are, from an image to another of the same shape and frame."""
        before, given = len(self._problems), "initial" if addend.initial is not None else ""
        given = "gain" if addend.gain is not None else "offset" if addend.offset is not None else given
        if not (target.words and source.words) or source.shape != target.shape:
            text = f"{source.label} is {_kind_of(source)}; {target.label} expects {_kind_of(target)}"
            self._report(addend.place, addend.path, text)
        elif source.frame and target.frame and source.frame != target.frame:
            text = f"{source.label} is in the {source.frame} frame; {target.label} expects {target.frame}"
            self._report(addend.place, addend.path, text)
        elif given:
            text = f"{given} goes to numbers; an image is wired as it is, and is black before its first"
            self._report(addend.place, addend.path, text)
        if len(self._problems) > before:
            return []
        return [Term(target.indices[0], source.indices[0], source.words, delayed=addend.delayed, is_image=True)]

    def _fits(self, addend: Addend, target: Signal, source: Signal) -> bool:
        """Shapes and frames; and units where no gain changes them."""
        before = len(self._problems)
        if source.shape != target.shape:
            text = f"{source.label} is {_shape(source.shape)}; {target.label} expects {_shape(target.shape)}"
            self._report(addend.place, addend.path, text)
        if source.frame and target.frame and source.frame != target.frame:
            text = f"{source.label} is in the {source.frame} frame; {target.label} expects {target.frame}"
            self._report(addend.place, addend.path, text)
        if addend.gain is None and not same_unit(source.unit, target.unit):
            gain = ratio(target.unit, source.unit)
            text = f"{source.label} is in {source.unit}; {target.label} expects {target.unit} (or a gain in {gain})"
            self._report(addend.place, addend.path, text)
        return len(self._problems) == before

    def _gain(self, addend: Addend, target: Signal, source: Signal) -> float:
        if addend.gain is None:
            return 1.0
        unit = "1" if same_unit(target.unit, source.unit) else ratio(target.unit, source.unit)
        values = self._array(addend.gain, unit, (), below(addend.path, "gain"))
        return values[0] if values else 1.0

    def _array(
        self, tree: Tree | None, unit: str, shape: tuple[int, ...], path: str, *, is_si: bool = False
    ) -> tuple[float, ...]:
        """Numbers of a shape, flat; none where nothing is written or something is wrong."""
        return () if tree is None else array(tree, unit, shape, path, self._problems, is_si=is_si)


def array(
    tree: Tree, unit: str, shape: tuple[int, ...], path: str, problems: list[Problem], *, is_si: bool = False
) -> tuple[float, ...]:
    """The numbers written in the tree, flat in row-major order; none, and a problem, where they are wrong."""
    before = len(problems)
    nested = parameters.numbers(tree, unit, path, problems, unit if is_si else "")
    if len(problems) > before:
        return ()
    try:
        values = np.asarray(nested, np.float64)
    except (ValueError, OverflowError):
        problems.append(Problem(tree.place, path, f"lists of different lengths; expected {_shape(shape)}"))
        return ()
    if values.shape != shape:
        problems.append(Problem(tree.place, path, f"{_shape(values.shape)}; expected {_quantity_of(shape, unit)}"))
        return ()
    return tuple(values.ravel().tolist())


def merged(terms: list[Term]) -> tuple[Term, ...]:
    """Terms whose targets and sources follow each other made one."""
    result: list[Term] = []
    for term in terms:
        last = result[-1] if result else None
        if last is not None and _continues(last, term):
            result[-1] = replace(
                last,
                count=last.count + term.count,
                offset=_joined(last, term, "offset"),
                initial=_joined(last, term, "initial"),
            )
        else:
            result.append(term)
    return tuple(result)


def _continues(last: Term, term: Term) -> bool:
    same = (last.gain, last.delayed, last.assigns) == (term.gain, term.delayed, term.assigns)
    follows = term.gain == 0.0 == term.source == last.source or term.source == last.source + last.count
    is_image = last.is_image or term.is_image
    return same and follows and term.target == last.target + last.count and not is_image


def _joined(last: Term, term: Term, name: str) -> tuple[float, ...]:
    first, second = getattr(last, name), getattr(term, name)
    if not first and not second:
        return ()
    return (first or (0.0,) * last.count) + (second or (0.0,) * term.count)


def _common_runs(targets: tuple[int, ...], sources: tuple[int, ...]) -> list[tuple[int, int]]:
    """Maximal stretches contiguous on both sides: (position, count)."""
    cuts = sorted({position for indices in (targets, sources) for position, _, _ in runs(indices)} | {len(targets)})
    return [(a, b - a) for a, b in pairwise(cuts)]


def _shape(shape: tuple[int, ...]) -> str:
    return "a list of " + " x ".join(map(str, shape)) if shape else "a single number"


def image_of(shape: tuple[int, ...]) -> str:
    """An image of a shape in words."""
    height, width, *channels = shape
    return f"{'an RGB' if channels else 'a grey'} image, {width} x {height} pixels"


def _kind_of(signal: Signal) -> str:
    return image_of(signal.shape) if signal.words else _quantity_of(signal.shape, signal.unit)


def _quantity_of(shape: tuple[int, ...], unit: str) -> str:
    return f"{_shape(shape)} in {unit}" if unit != "1" else _shape(shape)
