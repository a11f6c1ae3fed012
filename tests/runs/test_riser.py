"""The riser scenes from YAML to log, and what is asked of their logs off line."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipeline.analysis.estimates import estimates
from pipeline.analysis.page.line_estimate import charts_of, tab
from pipeline.analysis.page.signals import Signals
from pipeline.cli import main
from pipeline.commands import noise as noise_command
from pipeline.errors import LogError
from pipeline.estimation.fitting import Fit, fit_noises, noises_of
from pipeline.estimation.record import record_of
from pipeline.estimation.smoothing import smooth
from pipeline.log.reader import open_log
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph

SCENARIOS = Path(__file__).parents[2] / "scenarios"
LENGTH, PIECES, END = 8.19, 82, 4.6  # of the riser [m], its bars, and where the estimated metre ends [m]


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    folder, made = tmp_path_factory.mktemp("riser"), {}
    # Images are dear: two periods of the fairlead after its ramp, and the others whole.
    for name, duration in {"riser_tank": "7 s", "riser_blind": None, "riser_unforced": None}.items():
        scenario = load_scenario(SCENARIOS / f"{name}.yaml", duration=duration)
        run_scenario(scenario, build_graph(scenario), folder / f"{name}.mcap", Options(scene=False), lambda _: None)
        made[name] = open_log(folder / f"{name}.mcap")
    return made


def true_tension(log):
    """At the end of the estimated metre, at the estimator's frames."""
    middles = (np.arange(PIECES) + 0.5) * LENGTH / PIECES
    there = np.array([np.interp(END, middles, row) for row in log.port("riser", "tension")])
    return np.interp(log.times("best"), log.times("riser"), there)


def test_tension_from_a_cameras_images(logs):
    """Images, marks and estimates of a riser of 82 bars on a bed, which is another model than the filter's.

    Seen over 11 s: rms 5 % of the mean and bias 1 %, two and three times of which are allowed; and within 3 of the
    stated deviations always. NIS is chi-square of 12 by 100 frames whose errors go on for some: 1 to 30 %.
    """
    log = logs["riser_tank"]
    late = log.times("best") > 3e9
    true = true_tension(log)[late]
    error, deviation = log.port("best", "end_tension")[late] - true, log.port("best", "deviation.end_tension")[late]
    assert abs(error.mean()) < 0.03 * true.mean()
    assert np.sqrt((error**2).mean()) < 0.1 * true.mean()
    assert (np.abs(error) < 3.0 * deviation).mean() > 0.98
    assert log.port("best", "nis")[late].sum() / log.port("best", "freedom")[late].sum() == pytest.approx(1.0, abs=0.3)
    # The post hides one of the six markers at times.
    assert 0.02 < (log.port("best", "used")[late] == 0.0).mean() < 0.1
    # The linear filters on the same frames: much worse, as printed by about all of it.
    others = {name: log.port(name, "end_tension")[late] - true for name in ("corrected", "published")}
    rms = {name: np.sqrt((e**2).mean()) for name, e in others.items()}
    assert 3.0 * np.sqrt((error**2).mean()) < rms["corrected"] < rms["published"]


def test_blind_for_two_seconds(logs):
    log = logs["riser_blind"]
    t, seen = log.times("best") * 1e-9, log.port("best", "used").sum(axis=1)
    blind = (t >= 6.3) & (t < 8.3)
    assert (seen[blind][1:] == 0).all()
    assert (seen[~blind] > 0).mean() > 0.98
    error = np.abs(log.port("best", "end_tension") - true_tension(log))
    deviation = log.port("best", "deviation.end_tension")
    assert deviation[blind][-1] > 2.0 * np.median(deviation[~blind])
    # It says so: what a fairlead under way does to the tension meanwhile is within three of its deviations.
    assert (error[blind] < 3.0 * deviation[blind]).all()
    assert (error[t > 9.0] < 4.0 * deviation[t > 9.0]).all()


def test_unforced_comes_to_rest(logs):
    log = logs["riser_unforced"]
    late = log.times("best") > 9e9
    true = true_tension(log)[late]
    assert np.ptp(true) < 0.05 * true.mean()
    error = log.port("best", "end_tension")[late] - true
    assert np.abs(error.mean()) < 3.0 * log.port("best", "deviation.end_tension")[late].mean()
    assert np.abs(log.port("best", "rate")[late]).mean() < 0.2


def test_smoothed_tension_is_better(logs):
    log = logs["riser_tank"]
    record = record_of(log, "best")
    smoothed = smooth(record)
    assert (smoothed.t_ns == log.times("best")).all()
    late, true = smoothed.t_ns > 3e9, true_tension(log)
    rms = [
        np.sqrt(((force - true)[late] ** 2).mean())
        for force in (np.hypot(smoothed.states[:, 10], smoothed.states[:, 11]), log.port("best", "end_tension"))
    ]
    assert rms[0] < 0.8 * rms[1]
    assert (smoothed.deviations()[10:-1] > 0.0).all()
    # The last frame has no later one: the filter's own.
    assert smoothed.states[-1] == pytest.approx(record_state(record), rel=1e-12)


def record_state(record):
    filter_ = record.begin()
    for u in record.inputs[1:]:
        filter_.step(u)
    return filter_.state


def test_noise_of_the_markers_by_likelihood(logs):
    # The tracker's 1 mm, from a log whose filter was told 3 mm: 400 frames of 12 numbers give 1 to 2 %; the rest is
    # the chain's, which differs from the riser's.
    record = record_of(logs["riser_unforced"], "best").with_parameters(marker_noise=3e-3)
    found = fit_noises(record, ("marker_noise",), 0.02)
    assert found.noises["marker_noise"] == pytest.approx(1e-3, rel=0.1)
    assert found.log_likelihood > found.before + 1000.0
    with pytest.raises(ValueError, match="no positive number"):
        fit_noises(record, ("pivot",))


def test_a_wild_marker_does_not_draw_the_noises_up(logs):
    """10 cm off in one frame in ten, of which the filter refuses all: the tracker's 1 mm comes out as without them."""
    record = record_of(logs["riser_unforced"], "best").between(3.0, 9.0)
    wild = record.inputs.copy()
    wild[5::10, 3] += 0.1
    found = [
        fit_noises(replace(record, inputs=u), ("marker_noise",), 0.02).noises["marker_noise"]
        for u in (record.inputs, wild)
    ]
    assert found[1] == pytest.approx(found[0], rel=0.05)


def noise(capsys, log, *words):
    """What `towline noise` says: its status, standard output and standard error."""
    status = main(["noise", str(log.path), *words])
    return status, *capsys.readouterr()


def test_noise_command_tells_what_to_paste(logs, capsys):
    """The tracker's 1 mm lies in the interval, to what the riser's many bars add; its YAML is read as it is printed."""
    words = ("--fit", "marker_noise", "--window", "3", "9")
    status, text, _ = noise(capsys, logs["riser_unforced"], *words, "--json")
    told = json.loads(text)
    row = told["parameters"]["marker_noise"]
    assert (status, told["component"], row["unit"]) == (0, "best", "m")
    assert 0.9e-3 < row["low"] < row["fitted"] < row["high"] < 1.1e-3
    # 170 frames of 12 numbers: a deviation of 1 / sqrt(2 * 2040) of the noise each way, some more as states are fitted.
    assert row["high"] / row["low"] - 1.0 == pytest.approx(4.0 / np.sqrt(4080.0), rel=0.3)
    # The moments' noise, which is not fitted here, is more than this scene needs.
    assert told["nis"]["fitted"] == pytest.approx(0.9, abs=0.1)
    status, text, error = noise(capsys, logs["riser_unforced"], *words)
    assert (status, text) == (0, "")
    line = re.search(r"^ +marker_noise: (.*)$", error, re.MULTILINE)[1]
    scenario = load_scenario(SCENARIOS / "riser_unforced.yaml", (f"best.marker_noise={line}",))
    node = next(node for node in build_graph(scenario).nodes if node.name == "best")
    assert node.parameters.marker_noise == pytest.approx(row["fitted"], rel=5e-3)


def test_a_noise_that_the_log_does_not_tell_is_said_not_to_be_where_it_is_pasted_from(logs, capsys):
    record = record_of(logs["riser_unforced"], "best").between(3.0, 4.0)
    fit = Fit({"moment_noise": 1e-9, "marker_noise": 1e-3}, {"moment_noise": np.inf, "marker_noise": 0.01}, 2.0, 1.0, 9)
    walk = record.walk()
    noise_command._print("best", record, fit, walk, walk)
    pasted = capsys.readouterr().err.splitlines()[-2:]
    assert pasted[0].strip() == "moment_noise: 1e-09 N*m*s^0.5  # not told by this log"
    assert pasted[1].strip() == "marker_noise: 0.001 m"


@pytest.mark.parametrize(
    ("name", "words", "said"),
    [
        ("riser_tank", (), "2 estimators; choose one by --component best or corrected"),
        ("riser_tank", ("--component", "vision"), "no component vision of estimator.best or estimator.corrected"),
        (
            "riser_tank",
            ("--component", "best", "--fit", "marker_noise"),
            "no noise that has an effect here; expected of",
        ),
        ("riser_blind", ("--window", "6.4", "8.2"), "best saw no marker"),
        ("riser_blind", ("--window", "100", "200"), "--window: 100 to 200 s holds 0 of its steps"),
        ("riser_blind", ("--window", "1 N", "2"), "--window: "),
    ],
)
def test_noise_command_refuses_in_one_line(logs, capsys, name, words, said):
    status, text, error = noise(capsys, logs[name], *words)
    assert (status, text) == (1, "")
    assert said in error
    assert len(error.splitlines()) == 1


def test_noises_that_have_an_effect(logs):
    best, corrected = (record_of(logs["riser_tank"], name) for name in ("best", "corrected"))
    expected = ("chain_noise", "moment_noise", "end_force_spread", "pivot_acceleration", "end_force_time", "pivot_time")
    assert noises_of(best) == expected
    assert noises_of(corrected) == ("chain_noise", "force_noise")
    more = best.with_parameters(
        takes_covariance=False, pivot="fixed", tilts=(0.5,), gyros=(0.5,), end_tension_noise=0.1
    )
    measured = ("marker_noise", "end_tension_noise", "tilt_noise", "gyro_noise")
    assert noises_of(more) == (*measured, "moment_noise", "end_force_spread", "end_force_time")


def test_report_shows_estimates_beside_the_line(logs):
    # The truth is found by the estimated nodes alone: the same part of the line as the markers' distances say, to 1 %.
    log = logs["riser_tank"]
    signals = Signals(log)
    found = {one.name: one for one in estimates(signals)}
    assert set(found) == {"best", "corrected", "published"}
    best = found["best"]
    assert best.true_tension == pytest.approx(true_tension(log), rel=0.01, abs=0.02)
    assert np.median(np.abs(best.angle - best.true_angle)) < 0.01
    charts = [item for item in tab(signals).items if not isinstance(item, str)]
    assert [chart.title for chart in charts[:2]] == ["Tension at the end", "Angles of the bars"]
    assert "simulated" in [series.name for series in charts[0].series]


def test_hidden_marker_of_the_pivot_throws_nothing_off_with_chain_noise(logs):
    """One and two seconds without it, five bars for a line of 82 whose markers the images give to 0.1 mm.

    With 0.5 mm more, what five chords lack of arcs that turn by 0.15 to 0.25 rad each, nothing is refused.
    """
    record, told = record_of(logs["riser_tank"], "best"), {}
    hidden = record.inputs.copy()
    hidden[100:128, 18] = hidden[140:196, 18] = 0.0
    for noise in (0.0, 5e-4):
        filter_ = replace(record, inputs=hidden).with_parameters(chain_noise=noise).begin()
        told[noise] = np.array(
            [[filter_.step(u)["nis"].item(), (filter_["used"] < 0.0).sum(), filter_["beginnings"]] for u in hidden[1:]]
        )
    assert told[0.0][:, 0].max() > 1000.0
    assert told[5e-4][:, 0].max() < 50.0
    assert (told[5e-4][:, 1:] == 0.0).all()


def test_a_camera_shifted_unnoticed_is_got_over_with_chain_noise(logs):
    """5 cm from the 140th frame on: a second later within 0.5 N (a quarter), without it 10 N off and more."""
    log, error = logs["riser_tank"], {}
    record, true = record_of(log, "best"), true_tension(log)
    shifted = record.inputs.copy()
    shifted[140:, 0:18:3] += 0.05
    for noise in (0.0, 5e-4):
        filter_ = record.with_parameters(chain_noise=noise).begin()
        found = np.array([filter_.step(u)["end_tension"].item() for u in shifted[1:]])
        error[noise] = np.abs(found - true[1:])[168:].max()
    assert error[5e-4] < 0.5
    assert error[0.0] > 10.0


def test_chain_noise_is_fitted_from_none(logs):
    """Markers set off by 0.4 mm each way: to 10 %, with what the chain lacks already; a log that has none can begin."""
    record = record_of(logs["riser_tank"], "best").between(3.0, 6.0)
    scattered = record.inputs.copy()
    scattered[:, [0, 2, 3, 5, 6, 8, 9, 11, 12, 14, 15, 17]] += 4e-4 * np.random.default_rng(1).normal(
        size=(len(scattered), 12)
    )
    found = fit_noises(replace(record, inputs=scattered), ("chain_noise",), 0.02)
    assert found.noises["chain_noise"] == pytest.approx(4e-4, rel=0.1)
    assert found.log_likelihood > found.before + 100.0
    corrected = record_of(logs["riser_tank"], "corrected").with_parameters(chain_noise=1e-3).begin()
    plain = record_of(logs["riser_tank"], "corrected").begin()
    assert (corrected["deviation.angle"] > 1.1 * plain["deviation.angle"]).all()


def test_report_tells_doubts_and_leaves_out_what_would_hide_the_curves(logs):
    signals = Signals(logs["riser_tank"])
    one = estimates(signals)[0]
    t = one.t
    doubted, begun = np.zeros(len(t), bool), np.zeros(len(t))
    doubted[20:30], begun[29:] = True, 1.0
    wild = one.deviation.copy()
    wild[40:50] = 1000.0
    tension, _, _, squares = charts_of(replace(one, contradicted=doubted, beginnings=begun, deviation=wild))
    assert list(squares.bands) == [(pytest.approx(t[20]), pytest.approx(t[30], abs=0.036))]
    assert f"In 10 of {len(t)} frames (shaded)" in squares.caption
    assert "new beginnings: 1." in squares.caption
    drawn = next(series for series in tension.series if series.name == "+2σ").values
    assert np.isnan(drawn[40:50]).all()
    assert np.isfinite(np.delete(drawn, range(40, 50))).all()
    assert "out of the figure" in tension.caption
    calm = charts_of(replace(one, contradicted=np.zeros(len(t), bool), beginnings=0.0 * begun))
    assert not calm[3].bands
    assert "out of the figure" not in calm[0].caption


def test_what_is_no_estimator_is_refused(logs):
    with pytest.raises(LogError, match=r"no component riser of estimator\.best or estimator\.corrected"):
        record_of(logs["riser_tank"], "riser")
