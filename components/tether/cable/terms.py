"""Which terms of a line are on, and the number that decides it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from components.contract import Term
from components.tether.cable.table import penalty, spans

if TYPE_CHECKING:
    from components.tether.cable.model import Cable


def terms(cable: Cable) -> tuple[Term, ...]:
    """The line's terms in the order in which the balance adds them, then what changes it in time and the stepping."""
    return (*_line(cable), *_water(cable), *_bed(cable), *_pieces(cable), *_changes(cable))


def _line(cable: Cable) -> tuple[Term, ...]:
    ea, tau, stiffest = cable.axial_stiffness, cable.damping_time, max(s.stiff for s in spans(cable))
    told = "no axial_stiffness" if ea is None else f"axial_stiffness is {ea:g} N"
    if ea is None and (cable.bond_a or cable.bond_b):
        ea = penalty(cable)
        told += f", which is {ea:.3g} N on a bond"
    return (
        Term("stretching", ea is not None, told),
        Term("slack", cable.slackens, "takes no compression" if cable.slackens else "takes compression"),
        Term("bending", stiffest > 0.0, f"bending_stiffness is {stiffest:g} N m^2"),
        Term("internal damping", tau > 0.0 and (ea is not None or stiffest > 0.0), f"damping_time is {tau:g} s"),
    )


def _water(cable: Cable) -> tuple[Term, ...]:
    parts = spans(cable)
    across, along = max(2.0 * s.drag_n / s.l0 for s in parts), max(2.0 * s.drag_t / s.l0 for s in parts)
    added = max(2.0 * max(s.added_n, s.added_t) / s.l0 for s in parts)
    uniform, levels, waves = cable.current, len(cable.current_profile), len(cable.waves)
    told = f"{levels} levels" if levels else f"({uniform[0]:g}, {uniform[1]:g}, {uniform[2]:g}) m/s"
    depths = len(cable.current_depths)
    where = f" at {depths} depths" if depths else ""
    heard = f"; from the port current too{where}" if cable.current_input else ""
    is_flowing = bool(levels) or any(uniform) or cable.current_input
    return (
        Term("drag", across > 0.0 or along > 0.0, f"{across:g} across and {along:g} along, N s^2/m^3"),
        Term("added mass", added > 0.0, f"{added:g} kg/m beside {cable.mass_per_length:g} kg/m"),
        Term("current", is_flowing, f"current is {told}{heard}"),
        Term("waves", waves > 0, f"waves has {waves} components"),
    )


def _bed(cable: Cable) -> tuple[Term, ...]:
    depth, mu = cable.seabed, cable.seabed_friction
    return (
        Term("seabed", depth is not None, "no seabed given" if depth is None else f"seabed is at {depth:g} m"),
        Term("seabed friction", depth is not None and mu > 0.0, f"seabed_friction is {mu:g}"),
    )


def _pieces(cable: Cable) -> tuple[Term, ...]:
    sections, clumps = len(cable.sections), len(cable.clumps)
    return (
        Term("sections", sections > 0, f"sections has {sections} parts"),
        Term("clumps", clumps > 0, f"clumps has {clumps}"),
    )


def _changes(cable: Cable) -> tuple[Term, ...]:
    winch, load, cut = cable.winch, cable.breaking_load, cable.cut
    bonded, fixed = cable.bond_a or cable.bond_b, cable.sub_steps
    limit = f"breaking_load is {load:g} N" if load else "no breaking_load"
    told = f"; an event cuts segment {cut}" if cut else ""
    if bonded:
        stepping = "on a bond the line takes one step a period"
    elif fixed:
        stepping = f"sub_steps is {fixed}"
    else:
        stepping = f"a sub-step's positions are kept to {cable.accuracy * cable.length:.2g} m (accuracy)"
    return (
        Term("winch", winch != "none", "no winch" if winch == "none" else f"winch is at end {winch}"),
        Term("breaking", load > 0.0 or cut > 0, limit + told),
        Term("error control", not bonded and not fixed, stepping),
    )
