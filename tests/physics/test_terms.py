"""Every model says what it leaves out, and which of its terms its parameters turn on, as --explain prints them."""

from pathlib import Path

import pytest

from components.markers.tracker.component import COMPONENT as TRACKER
from components.motion.course.component import COMPONENT as COURSE
from components.motion.ellipse.component import COMPONENT as ELLIPSE
from components.motion.hand.component import COMPONENT as HAND
from components.motion.van_der_pol.component import COMPONENT as VAN_DER_POL
from components.tether.cable.component import COMPONENT as CABLE
from components.tether.catenary.component import COMPONENT as CATENARY
from components.tether.linkage.component import COMPONENT as LINKAGE
from components.tether.quasistatic.component import COMPONENT as QUASISTATIC
from components.vessel.mass.component import COMPONENT as MASS
from components.winch.drum.component import COMPONENT as DRUM
from pipeline.catalogue import find, models

MARKERS = {"length": 3.0, "segments": 10, "markers": 5, "spacing": 0.5}
WINCH = {"max_speed": 1.0, "max_acceleration": 1.0, "stall_tension": 1e3, "stored": 50.0}
LINE = {"length": 10.0, "segments": 4, "mass_per_length": 1.0, "volume_per_length": 0.0, "drag_diameter": 0.0}
HALVES = (
    {"length": 5.0, "segments": 2, "drag_diameter": 0.1},
    {"length": 5.0, "segments": 2, "volume_per_length": 1e-4},
)
STIFF = {"bending_stiffness": 1.0, "sections": tuple(half | {"bending_stiffness": 0.0} for half in HALVES)}
TETHER = {"length": 3.0, "weight": 1.0, "axial_stiffness": 1e5, "drag_diameter": 0.01}
SWEEP = {"moves": ("slow sweep north",), "durations": (15.0,)}


@pytest.mark.parametrize(
    ("component", "given", "on"),
    [
        (MASS, {"mass": 1.0}, set()),
        (MASS, {"mass": 1.0, "stiffness": (0.0, 2.0, 0.0), "takes_law": True}, {"springs", "bonded line"}),
        (MASS, {"mass": 1.0, "damping": (0.0, 0.0, 1.0), "takes_force": True}, {"dampers", "force from outside"}),
        (TRACKER, MARKERS, set()),
        (TRACKER, {**MARKERS, "noise": 1e-3, "lost_time": 0.1}, {"noise", "loss of markers"}),
        (DRUM, WINCH, set()),
        (DRUM, {**WINCH, "speed": 0.2, "commanded": True}, {"constant speed", "command from outside"}),
        (
            ELLIPSE,
            {"centre": (0.0, 0.0, 0.0), "frequency": 0.5, "ramp": 1.0, "sine": (0.0, 1.0, 0.0)},
            {"with the sine"},
        ),
        (ELLIPSE, {"centre": (0.0, 0.0, 0.0), "frequency": 0.0, "ramp": 1.0, "sine": (0.0, 1.0, 0.0)}, set()),
        (HAND, SWEEP, {"programme of moves"}),
        (COURSE, {"table": ((0.0,) * 4, (1.0, 1.0, 0.0, 0.0))}, set()),
        (COURSE, {"table": ((0.0,) * 4, (1.0, 1.0, 0.0, 0.0), (2.0, 1.0, 1.0, 0.0))}, {"manoeuvre"}),
        (HAND, {**SWEEP, "tremor": 1e-3}, {"programme of moves", "unsteadiness"}),
        (HAND, {"table": ((0.0, 0.0, 0.0, 0.0), (1.0, 0.1, 0.0, 0.0)), "tremor": 1e-3}, {"table"}),
        (VAN_DER_POL, {"mu": 0.0, "coupling": 0.3}, {"coupling"}),
        (CABLE, LINE | {"damping_time": 0.1}, {"slack", "error control"}),
        (CABLE, LINE | {"bond_b": True}, {"slack", "stretching"}),
        (
            CABLE,
            LINE | {"axial_stiffness": 1e5, "damping_time": 0.1, "sub_steps": 1},
            {"slack", "stretching", "internal damping"},
        ),
        # what sections give, and not what they all replace
        (CABLE, LINE | {"sections": HALVES}, {"slack", "sections", "drag", "added mass", "error control"}),
        (CABLE, LINE | STIFF, {"sections", "drag", "added mass", "error control"}),
        (
            CABLE,
            LINE | {"seabed": 5.0, "drag_diameter": 0.1, "waves": ({"amplitude": 1.0, "period": 8.0},), "winch": "a"},
            {"slack", "drag", "seabed", "waves", "winch", "error control"},
        ),
        (QUASISTATIC, TETHER, {"normal drag"}),
        (QUASISTATIC, TETHER | {"fluid_density": 0.0, "current_input": True}, {"current from outside"}),
        (
            QUASISTATIC,
            TETHER | {"tangential_drag": 0.02, "end_b": "free"},
            {"normal drag", "tangential drag", "body at a free end"},
        ),
        (CATENARY, {"length": 3.0, "weight": 1.0}, set()),
        (LINKAGE, {"length": 3.0, "normal_friction": 0.05}, {"linear drag"}),
        (
            LINKAGE,
            {
                "length": 3.0,
                "drag_diameter": 0.02,
                "mass_per_length": 0.3,
                "joint_stiffness": 1.0,
                "end_b": "pulled",
                "start": "arc",
            },
            {"quadratic drag", "inertia", "springs", "force at an end"},
        ),
        (CATENARY, {"length": 3.0, "weight": 1.0, "axial_stiffness": 1e4, "seabed": 2.0}, {"elasticity", "seabed"}),
    ],
)
def test_terms_follow_the_parameters(component, given, on):
    terms = component.terms(component.parameters(**given))
    assert {term.name for term in terms if term.on} == on
    assert all(term.why for term in terms)


@pytest.mark.parametrize("model", models())
def test_every_model_states_its_assumptions(model):
    _, component = find(model, Path())
    assert component.assumptions.endswith(".")
