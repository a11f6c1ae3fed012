"""What a line may have several of, each a mapping of parameters: currents' levels, waves, sections and clumps."""

from __future__ import annotations

from components.contract import Parameters, quantity


class Level(Parameters):
    """The current at one depth."""

    depth: float = quantity("m", "below the mean surface")
    velocity: tuple[float, float, float] = quantity("m/s", "of the water, NED")


class Wave(Parameters):
    """One component of a sea of Airy waves: elevation a cos(k x - omega t + phase), x along its way."""

    amplitude: float = quantity("m", "half the height", gt=0)
    period: float = quantity("s", "2 pi / omega", gt=0)
    direction: float = quantity("rad", "towards which it runs, clockwise from north", 0.0)
    phase: float = quantity("rad", "of the crest at the origin at t = 0", 0.0)


class Section(Parameters):
    """A part of a line from end a on; what it does not give is the line's."""

    length: float = quantity("m", "unstretched length", gt=0)
    segments: int = quantity("1", "number of equal segments", ge=1)
    mass_per_length: float | None = quantity("kg/m", "dry mass per length", None, gt=0)
    volume_per_length: float | None = quantity("m^2", "displaced volume per length", None, ge=0)
    axial_stiffness: float | None = quantity("N", "EA", None, gt=0)
    bending_stiffness: float | None = quantity("N*m^2", "EI", None, ge=0)
    drag_diameter: float | None = quantity("m", "diameter that drag refers to", None, ge=0)
    normal_drag: float | None = quantity("1", "C_n", None, ge=0)
    tangential_drag: float | None = quantity("1", "C_t", None, ge=0)
    normal_added_mass: float | None = quantity("1", "added over displaced mass, across", None, ge=0)
    tangential_added_mass: float | None = quantity("1", "added over displaced mass, along", None, ge=0)


class Clump(Parameters):
    """A clump weight or a float: a point on the line, shared by lever between the nodes on both its sides."""

    at: float = quantity("m", "unstretched length from end a", ge=0)
    mass: float = quantity("kg", "dry mass", 0.0, ge=0)
    volume: float = quantity("m^3", "displaced volume", 0.0, ge=0)
    drag_area: float = quantity("m^2", "C_d A of rho C_d A |v| v / 2", 0.0, ge=0)
    added_mass: float = quantity("1", "added over displaced mass; a sphere's is 0.5", 0.5, ge=0)
