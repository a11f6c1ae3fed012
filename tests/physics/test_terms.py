"""Every model says what it leaves out, and which of its terms its parameters turn on, as --explain prints them."""

from pathlib import Path

import pytest

from components.markers.tracker.component import COMPONENT as TRACKER
from components.motion.ellipse.component import COMPONENT as ELLIPSE
from components.motion.hand.component import COMPONENT as HAND
from components.motion.van_der_pol.component import COMPONENT as VAN_DER_POL
from components.vessel.mass.component import COMPONENT as MASS
from components.winch.drum.component import COMPONENT as DRUM
from pipeline.catalogue import find, models

MARKERS = {"length": 3.0, "segments": 10, "markers": 5, "spacing": 0.5}
WINCH = {"max_speed": 1.0, "max_acceleration": 1.0, "stall_tension": 1e3, "stored": 50.0}
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
        (HAND, {**SWEEP, "tremor": 1e-3}, {"programme of moves", "unsteadiness"}),
        (HAND, {"table": ((0.0, 0.0, 0.0, 0.0), (1.0, 0.1, 0.0, 0.0)), "tremor": 1e-3}, {"table"}),
        (VAN_DER_POL, {"mu": 0.0, "coupling": 0.3}, {"coupling"}),
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
