"""The tests' own FMUs are what they say: valid by fmpy's validation, and right in fmpy's own simulation."""

from __future__ import annotations

from math import sqrt
from pathlib import Path

import fmpy
import numpy as np
import pytest
from description import token
from fmpy.fmi3 import FMU3Slave
from fmpy.simulation import simulate_fmu
from fmpy.validation import validate_fmu
from foreign import ALL_KINDS, ARRAYS, BAD, BALL, KINDS, MODES, STAIR, TEXTS, VAN_DER_POL, ForeignFmus
from scipy.integrate import solve_ivp

CASES = [(model, fmi) for model in (VAN_DER_POL, BALL, STAIR, KINDS, TEXTS, ARRAYS, BAD) for fmi in (1, 2, 3)]
CASES += [(ALL_KINDS, 3)]


@pytest.mark.parametrize(("model", "fmi"), CASES, ids=lambda one: getattr(one, "name", str(one)))
def test_descriptions_are_valid(model, fmi, foreign: ForeignFmus):
    assert validate_fmu(str(foreign(model, fmi))) == []


def result(path: Path, stop: float, outputs: list[str], **options) -> np.ndarray:
    """fmpy's trajectories: a row a time, the time first."""
    found = simulate_fmu(str(path), stop_time=stop, output=outputs, **options)
    return np.array([list(row) for row in found], np.float64)


def oscillator(times: np.ndarray) -> np.ndarray:
    """DOP853 at 1e-12."""
    right = solve_ivp(
        lambda _, x: (x[1], (1 - x[0] ** 2) * x[1] - x[0]),
        (0, times[-1]),
        (2, 0),
        "DOP853",
        times,
        rtol=1e-12,
        atol=1e-12,
    )
    return right.y.T


@pytest.mark.parametrize(
    ("fmi", "kind"),
    [(1, "CoSimulation"), (2, "CoSimulation"), (3, "CoSimulation"), (2, "ModelExchange"), (3, "ModelExchange")],
)
def test_oscillator(fmi, kind, foreign):
    path = foreign(VAN_DER_POL, fmi)
    rows = result(path, 2.0, ["x", "v"], fmi_type=kind, output_interval=0.01, relative_tolerance=1e-9)
    # fourth order at 10 ms: (10 ms)^4 = 1e-8, with derivatives of order ten; CVode at its tolerance
    assert np.abs(rows[:, 1:] - oscillator(rows[:, 0])).max() < 1e-6


def impact_times(count: int) -> list[float]:
    """A ball dropped from 1 m with e = 0.7: t_k = sqrt(2/g) (1 + 2 sum e^j)."""
    first = sqrt(2 / 9.81)
    return [first * (1 + 2 * sum(0.7**j for j in range(1, k + 1))) for k in range(count)]


@pytest.mark.parametrize(
    ("fmi", "kind"),
    [(1, "CoSimulation"), (2, "CoSimulation"), (3, "CoSimulation"), (2, "ModelExchange"), (3, "ModelExchange")],
)
def test_ball(fmi, kind, foreign):
    rows = result(
        foreign(BALL, fmi), 2.0, ["h", "v", "bounces"], fmi_type=kind, output_interval=0.01, relative_tolerance=1e-9
    )
    for time, height, _, bounces in rows:
        past = [t for t in impact_times(12) if t < time - 1e-6]
        if min(abs(time - t) for t in impact_times(12)) < 1e-6:
            continue
        assert bounces == len(past)
        since = time - (past[-1] if past else 0.0)
        speed = 0.7 ** len(past) * sqrt(2 * 9.81) if past else 0.0
        expected = (0.0 if past else 1.0) + speed * since - 0.5 * 9.81 * since**2
        assert height == pytest.approx(expected, abs=1e-6)  # CVode's root finding


def test_ball_returns_early_in_event_mode(foreign):
    """fmpy steps on from the impact, so that rows stand at the impacts themselves."""
    path = foreign(BALL, 3)
    rows = result(
        path, 1.2, ["h", "v"], use_event_mode=True, early_return_allowed=True, output_interval=0.1, record_events=True
    )
    for impact in impact_times(2):
        assert np.abs(rows[:, 0] - impact).min() < 1e-12


@pytest.mark.parametrize(
    ("fmi", "kind"), [(2, "CoSimulation"), (3, "CoSimulation"), (2, "ModelExchange"), (3, "ModelExchange")]
)
def test_stair(fmi, kind, foreign):
    rows = result(foreign(STAIR, fmi), 2.1, ["level"], fmi_type=kind, output_interval=0.1)
    between = [row for row in rows if min(row[0] % 0.25, 0.25 - row[0] % 0.25) > 1e-6]
    assert [row[1] for row in between] == [row[0] // 0.25 for row in between]


def test_kinds(foreign):
    start = {"count": 3, "on": True, "name": "näme", "gain": 2.0, "choice": 2}
    expected = {"real_out": 0, "int_out": 3, "choice_out": 2, "text_length": 5, "on_out": 1}
    for fmi in (1, 2, 3):
        found = simulate_fmu(str(foreign(KINDS, fmi)), stop_time=0.1, output=list(expected), start_values=start)
        assert {name: found[name][-1] for name in expected} == expected
    start, expected = {"large": 2**53 + 2}, {"byte_sum": 255, "large_out": 2**53 + 2}
    found = simulate_fmu(str(foreign(ALL_KINDS, 3)), stop_time=0.1, output=list(expected), start_values=start)
    assert {name: found[name][-1] for name in expected} == expected


def test_arrays(foreign, tmp_path):
    """Sized by the structural parameter in configuration mode."""
    path = foreign(ARRAYS, 3)
    place = fmpy.extract(str(path), str(tmp_path))
    fmu = FMU3Slave(guid=token("arrays"), unzipDirectory=place, modelIdentifier="arrays", instanceName="a")
    fmu.instantiate()
    fmu.enterConfigurationMode()
    fmu.setUInt64([1000], [3])
    fmu.exitConfigurationMode()
    fmu.setFloat64([32], list(range(9)))
    fmu.enterInitializationMode()
    fmu.setFloat64([0], [1, 10, 100])
    fmu.exitInitializationMode()
    assert list(fmu.getFloat64([16], 3)) == (np.arange(9.0).reshape(3, 3) @ [1, 10, 100]).tolist()
    assert list(fmu.getFloat64([300], 6)) == [1, 2, 3, 4, 5, 6]
    fmu.terminate()
    fmu.freeInstance()
    names = [one.name for one in fmpy.read_model_description(str(foreign(ARRAYS, 2))).modelVariables]
    assert names[:4] == ["u[1]", "u[2]", "y[1]", "y[2]"]
    assert "f[2,3]" in names
    assert "arm.tip.x" in names


@pytest.mark.parametrize("fmi", [1, 2, 3])
def test_bad_one_behaves_while_it_is_told_to(fmi, foreign):
    rows = result(foreign(BAD, fmi), 0.5, ["y"], output_interval=0.1)
    assert np.abs(rows[:, 1] - rows[:, 0]).max() < 1e-12
    late = {"mode": MODES.index("fails"), "at": 0.25}
    if fmi == 1:  # fmpy 0.3.32 takes the status of fmiDoStep for a pointer to a text: any but OK kills the process
        late["at"] = 0.65
    else:
        with pytest.raises(Exception, match="status 3"):
            result(foreign(BAD, fmi), 0.5, ["y"], output_interval=0.1, start_values=late)
    result(foreign(BAD, fmi), 0.2, ["y"], output_interval=0.1, start_values=late)
