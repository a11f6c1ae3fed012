"""FMUs of anyone's run by the pipeline: against the native run's digest, an integrator, closed forms and each other."""

from __future__ import annotations

import json
from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from foreign import ALL_KINDS, ARRAYS, BALL, KINDS, STAIR, VAN_DER_POL
from scipy.integrate import solve_ivp

from pipeline.cli import main
from pipeline.log.reader import open_log

ROOT = Path(__file__).parents[2]
WAYS = [
    (1, "co-simulation"),
    (2, "co-simulation"),
    (3, "co-simulation"),
    (2, "model-exchange"),
    (3, "model-exchange"),
]


@pytest.mark.parametrize("fmi", [2, 3])
def test_pool_chain_of_fmus_has_the_native_digest(fmi, fmu_of, run, tmp_path):
    """Every component of the scene replaced by its exported FMU; names, frames, shapes and wires stay."""
    words = ["run", str(ROOT / "scenarios/pool_chain.yaml"), "--until", "4s", "--out", str(tmp_path / "native.mcap")]
    assert main([*words, "--json"]) == 0
    native = json.loads(run.output())
    names = ("wall", "hand", "tether", "markers")
    inputs = {"tether": "end_a: wall.motion, end_b: hand.motion", "markers": "nodes: tether.nodes"}
    lines = [
        f"{name}: {{fmu: {fmu_of(f'pool_chain.yaml#{name}', fmi)}, inputs: {{{inputs.get(name, '')}}}}}"
        for name in names
    ]
    text = "\n".join(f"  {line}" for line in lines)
    scene = tmp_path / "pool.yaml"
    scene.write_text(f"duration: 4 s\nstep: 20 ms\nseed: 1\ncomponents:\n{text}\n")
    assert main(["run", str(scene), "--out", str(tmp_path / "fmus.mcap"), "--json"]) == 0
    found = json.loads(run.output())
    assert found["digest"] == native["digest"]
    assert found["validity"] == native["validity"] != {}
    judged = []
    for log in ("native.mcap", "fmus.mcap"):
        assert main(["validity", str(tmp_path / log), "--json"]) == 0
        cable = json.loads(run.output())["cables"]["markers"]
        judged.append({key: value for key, value in cable.items() if key not in ("wall_s", "scenario", "published")})
    last = judged[1]["line"]["notes"].pop()
    assert last.startswith("its FMU does not tell sections")
    assert judged[0] == judged[1]
    ports = [
        [(port.name, port.unit, port.shape, port.frame) for port in open_log(tmp_path / log).channel("tether").ports]
        for log in ("native.mcap", "fmus.mcap")
    ]
    assert ports[0] == ports[1]


def oscillator(times: np.ndarray, mu: float = 1.0) -> np.ndarray:
    """DOP853 at 1e-12."""
    right = solve_ivp(
        lambda _, x: (x[1], mu * (1 - x[0] ** 2) * x[1] - x[0]),
        (0, times[-1]),
        (2, 0),
        "DOP853",
        times,
        rtol=1e-12,
        atol=1e-12,
    )
    return right.y.T


@pytest.mark.parametrize(("fmi", "interface"), WAYS)
def test_oscillator(fmi, interface, foreign, run):
    log = run(f"a: {{fmu: {foreign(VAN_DER_POL, fmi)}, interface: {interface}}}", until="2 s")
    found = np.column_stack([log.port("a", "x"), log.port("a", "v")])
    # Runge-Kutta of fourth order at 10 ms: (10 ms)^4 = 1e-8 with derivatives of order ten; CVode begins anew 200 times
    # at 1e-9.
    assert np.abs(found - oscillator(np.arange(201) * 0.01)).max() < 2e-6


def impacts(count: int) -> list[float]:
    """A ball dropped from 1 m with e = 0.7: t_k = sqrt(2/g) (1 + 2 sum e^j)."""
    first = sqrt(2 / 9.81)
    return [first * (1 + 2 * sum(0.7**j for j in range(1, k + 1))) for k in range(count)]


@pytest.mark.parametrize(("fmi", "interface"), WAYS)
def test_ball_bounces(fmi, interface, foreign, run):
    """State events within steps; in FMI 3 co-simulation by early return and event mode."""
    log = run(f"a: {{fmu: {foreign(BALL, fmi)}, interface: {interface}}}", until="2 s")
    height, bounces = log.port("a", "h"), log.port("a", "bounces")
    for k, (h, n) in enumerate(zip(height, bounces, strict=True)):
        t, past = k * 0.01, [one for one in impacts(12) if one < k * 0.01]
        assert n == len(past)
        since = t - (past[-1] if past else 0.0)
        speed = 0.7 ** len(past) * sqrt(2 * 9.81) if past else 0.0
        # CVode's root finding, at 1e-9 a period
        assert h == pytest.approx((0.0 if past else 1.0) + speed * since - 0.5 * 9.81 * since**2, abs=3e-6)


@pytest.mark.parametrize(("fmi", "interface"), WAYS)
def test_stair_of_time_events(fmi, interface, foreign, run):
    log = run(f"a: {{fmu: {foreign(STAIR, fmi)}, interface: {interface}}}", until="1.1 s")
    assert log.port("a", "level").tolist() == [k // 25 for k in range(111)]


# FMI 1.0 has no word for it, and this FMU tells it in event mode only, which FMI 2.0 co-simulation lacks.
@pytest.mark.parametrize(("fmi", "interface"), WAYS[2:])
def test_an_fmu_may_end_the_run(fmi, interface, foreign, run):
    words = f"a: {{fmu: {foreign(STAIR, fmi)}, interface: {interface}, parameters: {{last: 3}}}}"
    log = run(words, status=1)
    assert "ends the simulation" in run.result["error"]
    assert "at t = 0.75 s" in run.result["error"]
    assert len(log.port("a", "level")) == 75


def test_inputs_at_t0_reach_the_outputs_at_t0(foreign, run):
    """Set in initialization mode, got after it; units are converted once: kN in the FMU, N outside."""
    for fmi in (1, 2, 3):
        a = f"a: {{fmu: {foreign(KINDS, fmi)}, inputs: {{real_in: 2.5 kN}}, parameters: {{gain: 3, offset: 100 N}}}}"
        log = run(a, until="20 ms")
        assert log.port("a", "real_out").tolist() == [7600.0] * 3


def test_whole_numbers_truths_and_items(foreign, run):
    words = "int_in: 7, on_in: 1, choice_in: 3"
    for fmi in (1, 2, 3):
        own = "count: -3, on: true, choice: low, name: 'four'"
        log = run(f"a: {{fmu: {foreign(KINDS, fmi)}, inputs: {{{words}}}, parameters: {{{own}}}}}", until="20 ms")
        found = {name: log.port("a", name)[-1] for name in ("int_out", "on_out", "choice_out", "text_length")}
        assert found == {"int_out": 4.0, "on_out": 0.0, "choice_out": 3.0, "text_length": 4.0}


def test_every_width_of_fmi_3(foreign, run):
    """The largest value of each type, and of 64 bits the largest that float64 counts to."""
    largest = {"int8": 127, "uint8": 255, "int16": 32767, "uint16": 65535, "int32": 2**31 - 1, "uint32": 2**32 - 1}
    largest |= {"int64": -(2**53), "uint64": 2**53}
    words = ", ".join(f"{name}_in: {value}" for name, value in largest.items())
    own = "large: 9007199254740992, blob: 'ff01'"
    log = run(f"a: {{fmu: {foreign(ALL_KINDS, 3)}, inputs: {{{words}, short_in: 0.5}}, parameters: {{{own}}}}}")
    assert {name: log.port("a", f"{name}_out")[-1] for name in largest} == largest
    assert log.port("a", "large_out")[-1] == 2**53
    assert log.port("a", "byte_sum")[-1] == 256
    assert log.port("a", "short_out")[-1] == 0.5


def test_numbers_that_do_not_fit_are_refused_by_name_and_time(foreign, run):
    path = foreign(ALL_KINDS, 3)
    run(f"a: {{fmu: {path}, parameters: {{large: 9007199254740993}}}}", status=1)
    assert "large_out is 9007199254740993, beyond 2^53" in run.result["error"]
    assert "t = 0 s" in run.result["error"]
    ramp = "source: {model: motion.van_der_pol, parameters: {position: 1}, inputs: {neighbour: 0}}"
    run(f"{ramp}\na: {{fmu: {path}, inputs: {{int_in: source.position}}}}", status=1)
    assert "its input int_in is 0.999945" in run.result["error"]
    assert "at t = 0.01 s" in run.result["error"]
    assert "whole numbers from -2147483648 to 2147483647" in run.result["error"]
    run(f"a: {{fmu: {path}, inputs: {{on_in: 2}}}}", status=1)
    assert "its input on_in is 2, and the FMU takes 0 or 1" in run.result["error"]
    run(f"a: {{fmu: {path}, inputs: {{uint8_in: 256}}}}", status=1)
    assert "uint8_in is 256" in run.result["error"]
    run(f"a: {{fmu: {path}, inputs: {{short_in: 1.0e+39}}}}", status=1)
    assert "short_in is 9.9999999999999994e+38, and the FMU takes numbers up to 3.4e+38" in run.result["error"]
    run(f"a: {{fmu: {path}, parameters: {{short_in: 1.0e+39}}}}", status=1)
    assert "must be at most 3.4028" in run.result["error"]


def test_arrays(foreign, run):
    """Of FMI 3 and `name[i,j]`, with a structural parameter that makes them longer; row by row."""
    for fmi in (2, 3):
        a = f"a: {{fmu: {foreign(ARRAYS, fmi)}, inputs: {{u: [2 m, 3 m]}}, parameters: {{A: [[1, 2], [3, 4]]}}}}"
        log = run(a, until="20 ms")
        assert log.port("a", "y")[-1].tolist() == [8.0, 18.0]
        assert log.port("a", "f")[-1].tolist() == [[2.0, 4.0, 6.0], [8.0, 10.0, 12.0]]
        assert log.port("a", "arm.tip.x")[-1] == 8.0
    own = "n: 3, A: [[1, 0, 0], [0, 2, 0], [0, 0, 3]]"
    log = run(f"a: {{fmu: {foreign(ARRAYS, 3)}, inputs: {{u: [1 m, 1 m, 1 m]}}, parameters: {{{own}}}}}", until="20 ms")
    assert log.port("a", "y")[-1].tolist() == [1.0, 2.0, 3.0]


@pytest.mark.parametrize(("fmi", "interface"), WAYS[1:])
def test_events_set_tunable_parameters(fmi, interface, foreign, run):
    """mu changes at 1 s; from there on by the integrator with the other mu."""
    top = "events: [{at: 1 s, set: {a.mu: 3}}]"
    log = run(f"a: {{fmu: {foreign(VAN_DER_POL, fmi)}, interface: {interface}}}", until="1.5 s", top=top)
    x, v = log.port("a", "x"), log.port("a", "v")
    right = solve_ivp(
        lambda _, y: (y[1], 3 * (1 - y[0] ** 2) * y[1] - y[0]), (0, 0.5), (x[100], v[100]), "DOP853", rtol=1e-11
    )
    assert x[-1] == pytest.approx(right.y[0, -1], abs=2e-6)  # as test_oscillator
    assert x[-1] != pytest.approx(oscillator(np.array([0, 1.5]))[-1, 0], abs=1e-2)


def test_an_input_without_a_wire_holds_its_start_value(foreign, run):
    log = run(f"a: {{fmu: {foreign(KINDS, 2)}, parameters: {{real_in: 3 N}}}}", until="20 ms")
    assert log.port("a", "real_out")[-1] == 3.0
    log = run(f"a: {{fmu: {foreign(KINDS, 2)}}}", until="20 ms")
    assert log.port("a", "real_out")[-1] == 0.0


@pytest.mark.parametrize(("fmi", "interface"), [(2, "co-simulation"), (3, "co-simulation"), (3, "model-exchange")])
def test_isolated_gives_the_same_bits(fmi, interface, foreign, run):
    a = f"a: {{fmu: {foreign(BALL, fmi)}, interface: {interface}, isolate: %s, overdue: 20 s}}"
    run(a % "false", until="0.6 s")
    here = run.result["digest"]
    run(a % "true", until="0.6 s")
    assert run.result["digest"] == here


def test_two_instances_of_one_fmu(foreign, run):
    path = foreign(VAN_DER_POL, 2)
    a = f"a: {{fmu: {path}, parameters: {{mu: 1, coupling: 0.1}}, inputs: {{neighbour: {{from: b.x, delay: true}}}}}}"
    b = f"b: {{fmu: {path}, parameters: {{mu: 2, coupling: 0.1}}, inputs: {{neighbour: a.x}}}}"
    log = run(f"{a}\n{b}", until="0.5 s")
    assert abs(log.port("a", "x")[-1] - log.port("b", "x")[-1]) > 1e-3
