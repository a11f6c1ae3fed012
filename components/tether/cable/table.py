"""The numbers that a line's kernels read: its discrete constants, and tables for those terms that need them."""

from __future__ import annotations

from math import cos, pi, sin, sqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from components.constants import GRAVITY
from components.contract import HEADER
from components.environment.current import LEVEL
from components.environment.waves import DEEP, wave_number
from components.tether.cable.line import (
    ANCHOR,
    BAND,
    BONDED,
    DRIVEN,
    FREE,
    FULL,
    ON_MESH,
    RATE,
    SCALE,
    SCRATCH,
    SLIDING,
    STATE,
    WATER,
    Line,
)
from components.tether.cable.part import PART

if TYPE_CHECKING:
    from components.tether.cable.model import Cable
    from components.tether.cable.pieces import Section

# Penalty of an inextensible line, EA over its dry weight: each linear solution then leaves about 1e-5 of the error in
# its lengths, and tensions far above its weight still converge.
PENALTY = 1e5
# On a bond the length follows the body's scheme, which knows no multiplier: there a line that is not to stretch has an
# EA of so many times its dry weight, so that 100 times its weight stretches it by 1e-5.
BONDED_STIFFNESS = 1e7
# The seabed's default stiffness: a line at rest sinks by this part of its drag diameter under its own weight.
SINKING = 0.1
# From here on the fields are no numbers of p, but of the state, the time, and p itself.
CONSTANTS = Line._fields.index("scale")


class Places(NamedTuple):
    """Where the terms' numbers stand in w and x, 0 where a term is off; and the lengths of w and x."""

    water: int
    anchors: int
    band: int
    full: int
    memory: int
    workspace: int
    state: int


def places(cable: Cable) -> Places:
    """The layout of w and x behind the nodes' records."""
    nodes = cable.segments + 1
    end = (SCRATCH + STATE + (ON_MESH if cable.winch != "none" else 0)) * nodes

    def put(is_on: bool, size: int) -> int:
        nonlocal end
        place = end if is_on else 0
        end += size if is_on else 0
        return place

    has_water = bool(cable.current_input or cable.waves or cable.current_profile or any(cable.current))
    has_anchors = cable.seabed is not None and cable.seabed_friction > 0.0
    has_band = any(section.stiff > 0.0 for section in spans(cable))
    memory = STATE * nodes + (SCALE if cable.winch == "none" else RATE + 1)
    return Places(
        water=put(has_water, WATER * nodes + 1 + LEVEL * len(heard_depths(cable))),
        anchors=put(has_anchors, (2 * ANCHOR + SLIDING) * nodes),
        band=put(has_band, BAND * nodes),
        full=put(has_water, FULL * nodes),
        memory=memory if has_anchors else 0,
        workspace=end,
        state=memory + (ANCHOR * nodes if has_anchors else 0),
    )


class Span(NamedTuple):
    """Constants of equal segments that follow each other: as those of Line, half a segment's."""

    length: float
    segments: int
    l0: float
    k: float
    mass: float
    added_n: float
    added_t: float
    weight: float
    drag_n: float
    drag_t: float
    displaced: float
    stiff: float

    @property
    def record(self) -> tuple[float, ...]:
        """A segment's numbers in p, from l0 on."""
        return self[2:]


def _span(cable: Cable, section: Section | None, penalty: float) -> Span:
    def own(name: str) -> float:
        value = None if section is None else getattr(section, name)
        return getattr(cable, name) if value is None else value

    length, segments = own("length"), int(own("segments"))
    l0 = length / segments
    displaced = cable.fluid_density * own("volume_per_length")
    pressure = 0.5 * cable.fluid_density * own("drag_diameter") * l0 / 2
    ea = penalty if cable.axial_stiffness is None else own("axial_stiffness")
    return Span(
        length=length,
        segments=segments,
        l0=l0,
        k=ea / l0,
        mass=own("mass_per_length") * l0 / 2,
        added_n=displaced * own("normal_added_mass") * l0 / 2,
        added_t=displaced * own("tangential_added_mass") * l0 / 2,
        weight=(own("mass_per_length") - displaced) * cable.gravity * l0 / 2,
        drag_n=pressure * own("normal_drag"),
        drag_t=pressure * pi * own("tangential_drag"),
        displaced=displaced * l0 / 2,
        stiff=own("bending_stiffness"),
    )


def dry_weight(cable: Cable) -> float:
    """Of line and clumps [N]."""
    if not cable.sections:
        line = cable.mass_per_length * GRAVITY * cable.length
    else:
        line = sum((s.mass_per_length or cable.mass_per_length) * GRAVITY * s.length for s in cable.sections)
    return line + sum(clump.mass for clump in cable.clumps) * GRAVITY


def penalty(cable: Cable) -> float:
    """EA [N] of a line that is not to stretch: of the method of multipliers, or on a bond its own."""
    return (BONDED_STIFFNESS if cable.bond_a or cable.bond_b else PENALTY) * dry_weight(cable)


def spans(cable: Cable) -> tuple[Span, ...]:
    """The line's sections, or all of it."""
    return tuple(_span(cable, section, penalty(cable)) for section in cable.sections or (None,))


def numbers(cable: Cable) -> np.ndarray:
    """p after its header: the fields of Line, then the tables that they point at."""
    where, parts = places(cable), spans(cable)
    tables: list[float] = []

    def put(table: list[float]) -> int:
        place = HEADER + CONSTANTS + len(tables) if table else 0
        tables.extend(table)
        return place

    driven = (cable.end_a == "driven") + (cable.end_b == "driven")
    bonded = cable.bond_a or cable.bond_b
    clumps = _clumps(cable, parts)
    own = _segments(parts, clumps) if cable.sections or clumps else []
    bed = _bed(cable, parts)
    inextensible = cable.axial_stiffness is None and not bonded
    line = Line(
        n=cable.segments,
        end_a=_kind(cable.end_a, cable.bond_a),
        end_b=_kind(cable.end_b, cable.bond_b),
        l0=min(s.l0 for s in parts),
        k=max(s.k for s in parts),
        tau=cable.damping_time,
        mass=min(s.mass for s in parts),
        added_n=min(s.added_n for s in parts),
        added_t=min(s.added_t for s in parts),
        weight=parts[0].weight,
        drag_n=parts[0].drag_n,
        drag_t=parts[0].drag_t,
        tension_only=cable.slackens,
        rho_inf=0.0 if bonded else cable.rho_inf,
        sub_steps=cable.sub_steps,
        tolerance=cable.tolerance,
        max_iterations=cable.max_iterations,
        dry_weight=dry_weight(cable),
        displaced=parts[0].displaced,
        inextensible=inextensible,
        special=bool(own or where.water or inextensible),
        parts=put(own),
        current=put(_current(cable)),
        heard=9 * driven if cable.current_input else 0,
        heard_depths=put([len(heard_depths(cable)), *heard_depths(cable)] if cable.current_input else []),
        waves=put(_waves(cable)),
        water=where.water,
        clumps=put([len(clumps) / 6, *clumps] if clumps else []),
        bed=cable.seabed is not None,
        bed_depth=bed[0],
        bed_stiffness=bed[1],
        bed_onset=bed[2],
        bed_time=bed[3],
        friction=cable.seabed_friction,
        anchors=where.anchors,
        memory=where.memory,
        stiff=parts[0].stiff,
        clamps=put([*(cable.clamp_a or (0.0,) * 3), *(cable.clamp_b or (0.0,) * 3)] if where.band else []),
        band=where.band,
        full=where.full,
        length=cable.length,
        accuracy=cable.accuracy * cable.length,
        breaking_load=cable.breaking_load,
        winch={"none": 0, "a": 1, "b": -1}[cable.winch],
        rate=9 * driven + 3 * len(heard_depths(cable)),
        least_scale=cable.shortest,
        event_cut=cable.cut,
        scale=1.0,
        payout=0.0,
        payout_change=0.0,
        cut=-1,
        t=0.0,
        table=np.empty(0),
    )
    return np.array([*line[:CONSTANTS], *tables], np.float64)


def _kind(end: str, bond: bool) -> int:
    return FREE if end == "free" else BONDED if bond else DRIVEN


def _segments(parts: tuple[Span, ...], clumps: list[float]) -> list[float]:
    """A record for each segment; one more for the weights of the first node and of all others."""
    records = [s.record for s in parts for _ in range(s.segments)]
    halves = np.array([record[5] for record in records])
    weights = np.append(halves, 0.0) + np.append(0.0, halves)
    for k in range(0, len(clumps), 6):
        weights[int(clumps[k])] += clumps[k + 4]
    hung = np.concatenate([[0.0], np.cumsum(weights[1:])])
    table = [number for record, before in zip(records, hung, strict=False) for number in (*record, before)]
    return [*table, weights[0], *[0.0] * (PART - 2), hung[-1]]


def _clumps(cable: Cable, parts: tuple[Span, ...]) -> list[float]:
    """Six numbers for each node that bears a part of a clump."""
    nodes = np.concatenate([[0.0], np.cumsum([s.l0 for s in parts for _ in range(s.segments)])])
    table: list[float] = []
    for clump in cable.clumps:
        at = min(clump.at, nodes[-1])
        i = min(int(np.searchsorted(nodes, at, side="right")) - 1, len(nodes) - 2)
        after = (at - nodes[i]) / (nodes[i + 1] - nodes[i])
        displaced = cable.fluid_density * clump.volume
        for node, share in ((i, 1.0 - after), (i + 1, after)):
            if share > 0.0:
                weight = (clump.mass - displaced) * cable.gravity
                drag = 0.5 * cable.fluid_density * clump.drag_area
                shared = (clump.mass, displaced, displaced * clump.added_mass, weight, drag)
                table += [node, *(share * number for number in shared)]
    return table


def _current(cable: Cable) -> list[float]:
    """Number of levels, and the levels; a uniform current is one."""
    if any(cable.current):
        return [1, 0.0, *cable.current]
    levels = [number for level in cable.current_profile for number in (level.depth, *level.velocity)]
    return [len(cable.current_profile), *levels] if levels else []


def heard_depths(cable: Cable) -> tuple[float, ...]:
    """Depths at which another component gives the current."""
    return (cable.current_depths or (0.0,)) if cable.current_input else ()


def _waves(cable: Cable) -> list[float]:
    """Number of components, water depth, and the components."""
    depth = DEEP if cable.water_depth is None else cable.water_depth
    table: list[float] = [len(cable.waves), depth] if cable.waves else []
    for wave in cable.waves:
        omega = 2.0 * pi / wave.period
        k = wave_number(omega, depth, cable.gravity)
        table += [wave.amplitude, omega, k, cos(wave.direction), sin(wave.direction), wave.phase]
    return table


def _bed(cable: Cable, parts: tuple[Span, ...]) -> tuple[float, float, float, float]:
    """Depth [m], stiffness [N/m^2], onset [m] and damping time [s]; zeros without a bed.

    The onset is where the line's own weight rests. The default damping is critical for the line on the bed.
    """
    if cable.seabed is None:
        return 0.0, 0.0, 0.0, 0.0
    weight = abs(sum(2.0 * s.weight * s.segments for s in parts)) / cable.length
    mass = sum(2.0 * (s.mass + s.added_n) * s.segments for s in parts) / cable.length
    stiffness = cable.seabed_stiffness or weight / (SINKING * cable.drag_diameter)
    onset = 2.0 * weight / stiffness
    time = cable.seabed_damping_time
    return cable.seabed, stiffness, onset, 2.0 * sqrt(mass / stiffness) if time is None else time
