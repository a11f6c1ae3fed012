"""A scenario made into a graph: every name an index, units, shapes, frames, rates and cycles checked."""

from __future__ import annotations

import hashlib
from dataclasses import replace

from pipeline import ports, schedule, timeline
from pipeline.catalogue import closest, first_line
from pipeline.document import below, limited
from pipeline.errors import Place, Problem, WiringError
from pipeline.graph import Bond, Graph, Node, OtherEnd
from pipeline.hosts.fmu.component import FmuComponent
from pipeline.placement import parted
from pipeline.quantities import LATEST, as_time
from pipeline.wires import Draft, Wires, merged
from pipeline.written import Instance, Scenario, Tie

_LARGEST = 10_000_000  # float64 in one component's ports, state and scratch (80 MB); a line of 1000 nodes takes 40 000


def build_graph(scenario: Scenario) -> Graph:
    """The graph of a scenario. Raises WiringError with all problems of its wires, rates, bonds and events."""
    problems: list[Problem] = []
    graph = _Wiring(scenario, problems).graph()
    if problems:
        raise WiringError(limited(problems))
    return graph


def problems_of(scenario: Scenario) -> list[Problem]:
    """What is wrong with the wiring of a scenario that is itself broken; its broken components are left out."""
    problems: list[Problem] = []
    _Wiring(scenario, problems).graph()
    return problems


def seed_of(seed: int, name: str) -> int:
    """64 bits for one component: the first of SHA-256 over scenario seed and instance name."""
    return int.from_bytes(hashlib.sha256(f"{seed}/{name}".encode()).digest()[:8], "big")


class _Wiring:
    """One pass over the scenario, gathering problems instead of stopping at the first."""

    def __init__(self, scenario: Scenario, problems: list[Problem]):
        self._scenario, self._problems = scenario, problems
        self._drafts: dict[str, Draft] = {}
        self._broken = set(scenario.broken)
        self._board = 0

    def graph(self) -> Graph:
        """The graph; worth something only where no problem was found."""
        scenario = self._scenario
        for instance in scenario.instances:
            self._lay_out(instance)
        wires = Wires(self._drafts, self._broken, self._problems)
        drafts = list(self._drafts.values())
        for draft in drafts:
            for wire in draft.instance.wires:
                wires.connect(draft, wire)
        bonds = tuple(bond for tie in scenario.ties if (bond := self._bond(tie, wires)) is not None)
        is_tied = len(bonds) == len(scenario.ties) and not scenario.unread
        for draft in drafts:
            wires.rest(draft)
            if is_tied or not (draft.instance.component.bodies or draft.instance.component.lines):
                wires.check_wired(draft)
        wires.report_cycles(drafts)
        nodes = tuple(self._node(draft) for draft in drafts)
        ticks = self._ticks()
        events = timeline.events(scenario, self._drafts, self._broken, ticks, self._problems)
        direct = {(edge.producer, edge.consumer) for edge in wires.edges}
        stages = () if self._problems else schedule.stages(len(nodes), direct, [(b.body, b.line) for b in bonds])
        bonds = self._grouped(bonds, stages, nodes)
        bonds = tuple(replace(bond, other=self._other_end(bond, bonds, wires)) for bond in bonds)
        return Graph(scenario.step_ns, ticks, nodes, stages, self._board, bonds, events, scenario.start_ns)

    def _grouped(self, bonds: tuple[Bond, ...], stages: schedule.Stages, nodes: tuple[Node, ...]) -> tuple[Bond, ...]:
        """Bonds in the order of the groups that hold them, whose members must all have one period."""
        ordered: list[Bond] = []
        for group in (group for stage in stages for group in stage):
            inside = [bond for bond in bonds if bond.line in group]
            periods = {nodes[i].period for i in group}
            if inside and len(periods) > 1:
                instance = self._scenario.instances[group[0]]
                names = ", ".join(nodes[i].name for i in group)
                text = f"bond '{inside[0].name}' makes {names} repeat a step together; they need equal periods"
                self._report(instance.place, instance.path, text)
            if inside:
                self._check_hosts(inside[0].name, [nodes[i].name for i in range(len(nodes))], group)
            ordered += inside
        return tuple(ordered)

    def _check_hosts(self, bond: str, names: list[str], group: tuple[int, ...]) -> None:
        """What a bond ties repeats a step together, which it can on one host only."""
        hosts = self._scenario.hosts
        apart = parted(names, group, hosts.hosts)
        if apart is not None:
            first = next(names[i] for i in group if names[i] in hosts.hosts)
            text = f"bond '{bond}' ties {apart} to {first}, which is on '{hosts.hosts[first]}'; put both on one host"
            self._report(hosts.places[apart], f"hosts.{apart}", text)

    def _report(self, place: Place, path: str, text: str) -> None:
        self._problems.append(Problem(place, path, text))

    def _lay_out(self, instance: Instance) -> None:
        """Give the instance's outputs their place on the board."""
        kind, values = instance.component, instance.parameters
        try:
            inputs, outputs, sizes = tuple(kind.inputs(values)), tuple(kind.outputs(values)), kind.sizes(values)
            faults = [*ports.faults("input", inputs), *ports.faults("output", outputs), *ports.size_faults(sizes)]
            faults += [*ports.validity_faults(kind.validity, outputs), *ports.image_faults(kind, (*inputs, *outputs))]
            numbers = 0 if faults else sum(port.size for port in (*inputs, *outputs)) + sizes.state + sizes.workspace
            if numbers > _LARGEST:
                raise ValueError(f"it takes {numbers} numbers; expected at most {_LARGEST}")
            if not faults:
                kind.pack(values)
        except Exception as error:  # a third party's code
            inputs, outputs = (), ()
            faults = [f"{kind.name} cannot be set up with these parameters: {first_line(error)}"]
        if faults:
            for fault in faults:
                self._report(instance.given, instance.path, fault)
            self._broken.add(instance.name)
            return
        n_u = sum(port.size for port in inputs)
        index = len(self._drafts)
        self._drafts[instance.name] = Draft(instance, index, inputs, outputs, self._board, [], [""] * n_u)
        self._board += sum(port.size for port in outputs)

    def _ticks(self) -> int:
        """The number of ticks; 0 where a time is missing."""
        duration, step = self._scenario.duration_ns, self._scenario.step_ns
        if not duration or not step:
            return 0
        if duration % step:
            nearest = as_time(_nearest(duration, step))
            text = f"{as_time(duration)} is not a multiple of the step of {as_time(step)}; nearest is {nearest}"
            self._report(self._scenario.limit, "duration", text)
        start = self._scenario.start_ns
        if start + duration > LATEST:
            text = f"{as_time(duration)} from the start at {as_time(start)} is too long; times reach to 292 years"
            self._report(self._scenario.limit, "duration", text)
        return duration // step

    def _node(self, draft: Draft) -> Node:
        instance = draft.instance
        period = self._multiple(instance.period_ns, self._scenario.step_ns, instance, "period", "the step")
        self._check_steps(instance)
        record = instance.record.steps
        if instance.record.period_ns:
            own = instance.period_ns or self._scenario.step_ns
            record = self._multiple(instance.record.period_ns, own, instance, "record", "the component's period")
        return Node(
            name=instance.name,
            model=instance.model,
            component=instance.component,
            parameters=instance.parameters,
            seed=seed_of(self._scenario.seed, instance.name),
            period=period,
            record_every=record,
            inputs=draft.inputs,
            outputs=draft.outputs,
            start=draft.start,
            terms=merged(draft.terms),
        )

    def _check_steps(self, instance: Instance) -> None:
        """A component must step once at least, with a step that it can take."""
        if isinstance(instance.component, FmuComponent):
            for fault in instance.component.faults(instance.period_ns or self._scenario.step_ns):
                self._report(instance.tree.entries["fmu"].place, below(instance.path, "fmu"), fault)
        run_ns, limit = self._scenario.duration_ns, self._scenario.limit
        if 0 < run_ns < instance.period_ns:
            text = f"its period of {as_time(instance.period_ns)} is longer than the run of {as_time(run_ns)}"
            place = instance.tree.entries["period"].place if limit.file == self._scenario.source else limit
            self._report(place, below(instance.path, "period"), f"{text}: it would never step")

    def _multiple(self, time: int, of: int, instance: Instance, key: str, what: str) -> int:
        """How many times `of` goes into a time; 1 where one of them is missing."""
        if not time or not of:
            return 1
        if time % of:
            nearest = as_time(_nearest(time, of))
            text = f"{as_time(time)} is not a multiple of {what}, {as_time(of)}; nearest is {nearest}"
            self._report(instance.tree.entries[key].place, below(instance.path, key), text)
        return max(time // of, 1)

    def _bond(self, tie: Tie, wires: Wires) -> Bond | None:
        """Wire a bond's two bundles; None where an end is unknown, or tied by another bond."""
        body, line = self._end(tie, "body"), self._end(tie, "line")
        if body is None or line is None or self._is_taken(tie):
            return None
        hook, end = body.instance.component.bodies[tie.body.port], line.instance.component.lines[tie.line.port]
        if (body.instance.period_ns or self._scenario.step_ns) != (line.instance.period_ns or self._scenario.step_ns):
            text = f"'{body.name}' and '{line.name}' have different periods; a bond needs equal ones"
            self._report(tie.place, tie.path, text)
        before = len(self._problems)
        wires.connect(line, tie.wire(end.motion, body.name, hook.motion, delayed=False))
        wires.connect(body, tie.wire(hook.law, line.name, end.law, delayed=True))
        if len(self._problems) > before:
            return None
        motion, law, accepted = (
            wires.bundle_start(owner, name, tie)
            for owner, name in ((body, hook.motion), (line, end.law), (line, end.accepted))
        )
        target = wires.bundle_start(body, hook.law, tie, is_input=True)
        if len(self._problems) > before:
            return None
        return Bond(tie.name, line.index, body.index, motion, law, accepted, target, tie.tolerance, tie.rounds)

    def _is_taken(self, tie: Tie) -> bool:
        """Whether a bond above ties one of this one's ends already, which is reported."""
        before = len(self._problems)
        for other in self._scenario.ties[: self._scenario.ties.index(tie)]:
            for kind, mine, theirs in (("body", tie.body, other.body), ("line", tie.line, other.line)):
                if mine == theirs:
                    text = f"bonds '{other.name}' and '{tie.name}' both tie '{mine}'; a {kind}'s end takes one bond"
                    self._report(tie.places[kind], below(tie.path, kind), text)
        return len(self._problems) > before

    def _other_end(self, bond: Bond, bonds: tuple[Bond, ...], wires: Wires) -> OtherEnd | None:
        """The other end of the bond's line, if each of the two bodies there is on one bond alone and tells accelerance.

        Else None: a body on several bonds, or one that does not tell how it yields, is left to rounds in which each
        end's law has the other end held.
        """
        ties, drafts = {tie.name: tie for tie in self._scenario.ties}, list(self._drafts.values())
        facing = [j for j, other in enumerate(bonds) if other.line == bond.line and other.name != bond.name]
        if len(facing) != 1:
            return None
        pair = bond, bonds[facing[0]]
        ports = [drafts[b.body].instance.component.bodies[ties[b.name].body.port].accelerance for b in pair]
        is_alone = all(sum(other.body == b.body for other in bonds) == 1 for b in pair)
        here, there = (ties[b.name].line.port for b in pair)
        crosses = drafts[bond.line].instance.component.cross
        cross = crosses.get((here, there)) or crosses.get((there, here))
        if not (cross and is_alone and all(ports)):
            return None
        tie = ties[bond.name]
        start = self._matrix(drafts[bond.line], cross, tie, wires)
        accelerance = self._matrix(drafts[pair[1].body], ports[1], tie, wires)
        return OtherEnd(facing[0], start, (there, here) in crosses, accelerance)

    def _matrix(self, owner: Draft, name: str, tie: Tie, wires: Wires) -> int:
        """First index on the board of an output that must be 3x3."""
        shape = next((port.shape for port in owner.outputs if port.name == name), (3, 3))
        if shape != (3, 3):
            self._report(tie.place, tie.path, f"'{owner.name}.{name}' is {shape}; a bond needs it to be (3, 3)")
        return wires.bundle_start(owner, name, tie)

    def _end(self, tie: Tie, kind: str) -> Draft | None:
        """The component of a bond's end, if there is such an end."""
        name, path = (tie.body if kind == "body" else tie.line), below(tie.path, kind)
        place = tie.places[kind]
        draft = self._drafts.get(name.component)
        if draft is None:
            if name.component not in self._broken:
                self._report(
                    place, path, f"unknown component '{name.component}'{closest(name.component, list(self._drafts))}"
                )
            return None
        ends = draft.instance.component.bodies if kind == "body" else draft.instance.component.lines
        if isinstance(draft.instance.component, FmuComponent):
            text = "a bond repeats a step and takes laws of force, for which FMI has no words"
            remedy = "give the component by `model:`, or wire the FMU's force without a bond"
            self._report(place, path, f"'{name.component}' is an FMU, whose ends no bond can tie: {text}; {remedy}")
            return None
        if name.port not in ends:
            self._report(
                place, path, f"'{name.component}' has no {kind} end '{name.port}'{closest(name.port, list(ends))}"
            )
            return None
        return draft


def _nearest(time: int, of: int) -> int:
    """The multiple of `of` next to the time, at least one."""
    return max((time + of // 2) // of, 1) * of
