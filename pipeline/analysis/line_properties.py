"""What a recorded line is made of and what water it lay in, by the parameters in its log."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf, pi, sqrt

import numpy as np

from components.constants import GRAVITY
from pipeline.analysis.scenario_entries import Entries, array, number

# Parameters that give a line what a catenary has not, and what they are called.
BEYOND = {
    "bending_stiffness": "bending stiffness",
    "joint_stiffness": "springs in its joints",
    "sections": "parts of other properties",
    "clumps": "clump weights or floats",
    "waves": "waves",
}


@dataclass(frozen=True)
class Water:
    """The current at depths (m,), which increase, of velocity (m, 3) NED [m/s]: linear between, constant beyond.

    recorded: channel and port of what comes on top, ("", "") for nothing; its depths (j,), () for one velocity at all.
    """

    depths: np.ndarray
    velocity: np.ndarray
    recorded: tuple[str, str] = ("", "")
    recorded_depths: np.ndarray = field(default_factory=lambda: np.empty(0))


@dataclass(frozen=True)
class Properties:
    """Per unstretched length, means where sections differ.

    load: (3,) steady load, NED [N/m]: the weight in water. dry_weight [N/m]. mass, added: dry mass, and what water goes
    with it across [kg/m]. square, linear: drag across (first) and along, over |v| v [N s^2/m^3] and v [N s/m^2].
    flexibility: 1/EA [1/N], 0 where it does not stretch. seabed: its depth [m], inf for none; rough: with friction.
    held: whether end a, b is held. beyond: what the line has and a catenary has not. notes: what is not known.
    """

    length: float
    load: np.ndarray
    dry_weight: float
    mass: float
    added: float
    square: tuple[float, float]
    linear: tuple[float, float]
    flexibility: float
    seabed: float
    rough: bool
    held: tuple[bool, bool]
    water: Water
    beyond: tuple[str, ...]
    notes: tuple[str, ...]

    @property
    def weight(self) -> float:
        """Size of the load [N/m]."""
        return float(np.linalg.norm(self.load))

    @property
    def speed(self) -> float:
        """Speed across the line at which drag is as large as the weight in water [m/s]: where k v^2 + c v = w."""
        k, c, w = self.square[0], self.linear[0], self.weight
        if k == c == 0.0:
            return inf
        return 2.0 * w / (c + sqrt(c * c + 4.0 * k * w)) if w > 0.0 else 0.0

    @property
    def acceleration(self) -> float:
        """Acceleration across the line at which inertia is as large as the weight in water [m/s^2]."""
        virtual = self.mass + self.added
        return self.weight / virtual if virtual > 0.0 else inf


def properties(found: Entries, name: str) -> Properties | None:
    """Of the line of this name; None where its parameters do not tell its length and load.

    tether.cable gives mass and volume, the others their weight in water; one of another model is taken by the names of
    its parameters.
    """
    length = found.metres(name, "length")
    load, dry, mass, added = _masses(found, name)
    if length is None or load is None:
        return None
    density, diameter = found.number(name, "fluid_density"), found.number(name, "drag_diameter")
    pressure = 0.5 * density * diameter
    stiffness = found.number(name, "axial_stiffness")
    bed = number(found.given(name, "seabed"))
    water, notes = _water(found, name)
    if changed := sorted(key for key in found.changed if key.startswith(f"{name}.")):
        notes.append(f"events set {', '.join(changed)}: its parameters are taken as they were at the start")
    if "fmu" in found.components.get(name, {}):
        notes.append("its FMU does not tell sections, clump weights and current profiles: taken as if it had none")
    return Properties(
        length=length,
        load=load,
        dry_weight=dry,
        mass=mass,
        added=added,
        square=(pressure * found.number(name, "normal_drag"), pi * pressure * found.number(name, "tangential_drag")),
        linear=(found.number(name, "normal_friction"), found.number(name, "tangential_friction")),
        flexibility=1.0 / stiffness if stiffness else 0.0,
        seabed=inf if bed is None else bed,
        rough=found.number(name, "seabed_friction") > 0.0,
        held=(found.given(name, "end_a") != "free", found.given(name, "end_b") != "free"),
        water=water,
        beyond=tuple(text for key, text in BEYOND.items() if _is_there(found.given(name, key))),
        notes=tuple(notes),
    )


def _is_there(value: object) -> bool:
    """A term that is on: a number above 0, or a list with something in it."""
    return bool(value) if isinstance(value, list) else bool(number(value))


def _masses(found: Entries, name: str) -> tuple[np.ndarray | None, float, float, float]:
    """Load (3,) [N/m], dry weight [N/m], dry mass and added mass [kg/m]; None for a load that is not told."""
    given = found.array(name, "load")
    weight = number(found.given(name, "weight"))
    virtual = number(found.given(name, "virtual_mass"))
    mass, volume = number(found.given(name, "mass_per_length")), number(found.given(name, "volume_per_length"))
    if len(given) != 3 and weight is None and (mass is None or volume is None):
        return None, 0.0, 0.0, 0.0
    gravity = found.number(name, "gravity", GRAVITY)
    if mass is not None and volume is not None and weight is None:
        density = found.number(name, "fluid_density")
        mass, volume = _mean(found, name, "mass_per_length", mass), _mean(found, name, "volume_per_length", volume)
        load = np.array([0.0, 0.0, (mass - density * volume) * gravity])
        return load, mass * gravity, mass, density * volume * found.number(name, "normal_added_mass")
    load = given if len(given) == 3 else np.array([0.0, 0.0, weight or 0.0])
    if not mass:
        mass = virtual if virtual is not None else abs(load[2]) / gravity
    return load, mass * gravity, mass, 0.0


def _mean(found: Entries, name: str, parameter: str, own: float) -> float:
    """Over the sections, by their lengths; what a section does not give is the line's own."""
    sections = found.given(name, "sections") or []
    lengths = [number(section.get("length")) or 0.0 for section in sections]
    values = [number(section.get(parameter)) for section in sections]
    if not sum(lengths):
        return own
    return sum(s * (own if v is None else v) for s, v in zip(lengths, values, strict=True)) / sum(lengths)


def _water(found: Entries, name: str) -> tuple[Water, list[str]]:
    """The current in which the line lay, and what of it is not known."""
    levels, table = found.given(name, "current_profile") or [], found.array(name, "current")
    depths, velocity = np.zeros(1), np.zeros((1, 3))
    if levels:
        depths = np.array([number(level["depth"]) or 0.0 for level in levels])
        velocity = np.array([array(level["velocity"]) for level in levels])
    elif table.ndim == 2 and len(table):
        depths, velocity = found.array(name, "current_depth"), table
    elif table.shape == (3,):
        velocity = table[None]
    if found.given(name, "current_input") is not True:
        return Water(depths, velocity), []
    source = found.source(name, "current")
    note = [] if source[0] else ["its current comes by a wire that is no plain one: not counted"]
    return Water(depths, velocity, source, found.array(name, "current_depths")), note
