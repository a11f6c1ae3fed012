"""Logs with something odd in them: report and validity come out, and say in one line what is odd.

The sample of a pool chain is written anew with one thing changed: what of it is still known must be what it was.
"""

from __future__ import annotations

import json
import os
import re
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from components.contract import Port
from pipeline.analysis.page import others, thrusters
from pipeline.analysis.page.signals import Signals
from pipeline.cli import main
from pipeline.log.reader import ChannelInfo, open_log
from pipeline.log.recorder import ChannelSpec, Recorder, pack_rows

SAMPLE = Path(__file__).parents[2] / "logs" / "sample.mcap"
Channel = tuple[tuple[Port, ...], np.ndarray, np.ndarray]  # ports, times [ns], values
Change = Callable[[ChannelInfo, np.ndarray, np.ndarray], Channel | None]


def rewritten(out: Path, change: Change, names: tuple[str, ...] = (), scenario: bool = True) -> Path:
    """The sample with these channels changed (all, if none is named), None leaving one out."""
    with open_log(SAMPLE) as log:
        found = []
        for name, (t_ns, values) in log.read().items():
            info = log.channel(name)
            one = change(info, t_ns, values) if not names or name in names else (info.ports, t_ns, values)
            if one is not None:
                found.append((ChannelSpec(name, one[0], info.metadata), pack_rows(*one[1:])))
        attached = {"scenario.yaml": log.attachment("scenario.yaml")} if scenario else {}
    with Recorder(out, [spec for spec, _ in found], attachments=attached) as recorder:
        for i, (_, rows) in enumerate(found):
            recorder.rows(i, rows)
    return out


def at(rows: Callable[[int], object], value: float | None = None) -> Change:
    """Rows by their count: kept alone, or set to a value."""

    def change(info: ChannelInfo, t_ns: np.ndarray, values: np.ndarray) -> Channel:
        chosen = rows(len(t_ns))
        if value is None:
            return info.ports, t_ns[chosen], values[chosen]
        changed = values.copy()
        changed[chosen] = value
        return info.ports, t_ns, changed

    return change


def at_one_time(info: ChannelInfo, t_ns: np.ndarray, values: np.ndarray) -> Channel:
    return info.ports, np.full_like(t_ns, t_ns[3]), values


def of_nodes(count: int) -> Change:
    """A line of fewer nodes."""

    def change(info: ChannelInfo, t_ns: np.ndarray, values: np.ndarray) -> Channel:
        ports = tuple(replace(p, shape=(count, 3)) if p.name == "nodes" else p for p in info.ports)
        parts = [values[:, info.port(p.name)[1]][:, : p.size] for p in ports]
        return ports, t_ns, np.concatenate(parts, axis=1)

    return change


def third(k: int) -> slice:
    return slice(k // 3, 2 * k // 3)


def everything(k: int) -> slice:
    return slice(0, k)


LINE = ("tether",)
# What is changed, where, and a part of the line that says so ("": nothing is odd, only less is known).
ODD = {
    "no length": (at(everything, 0.0), LINE, "stand in one place in"),
    "no length for a while": (at(third, 0.0), LINE, "stand in one place in"),
    "not finite for a while": (at(third, np.nan), LINE, "hold numbers that are not finite"),
    "nowhere finite": (at(everything, np.inf), (), "hold numbers that are not finite"),
    "too large to be squared": (at(third, 1e300), (), "hold numbers that are not finite or beyond 1e+30"),
    "two nodes": (of_nodes(2), LINE, ""),
    "one node": (of_nodes(1), LINE, ""),
    "half missing": (at(lambda k: np.r_[0 : k // 4, 3 * k // 4 : k]), LINE, "tether: no message between"),
    "no message": (at(lambda k: slice(0, 0)), (), "has no message"),
    "one message": (at(lambda k: slice(0, 1)), (), ""),
    "no line": (lambda *_: None, LINE, ""),
    "all at one time": (at_one_time, (), "messages repeat a time: the first of each is kept"),
}


@pytest.mark.parametrize("odd", ODD)
def test_report_and_validity_come_out(odd, tmp_path, capsys):
    """The markers of the pool are judged by themselves, so the line is taken alone: without them, if it is odd."""
    change, names, said = ODD[odd]

    def changed(info: ChannelInfo, t_ns: np.ndarray, values: np.ndarray) -> Channel | None:
        if info.name == "markers" and names:
            return None
        return change(info, t_ns, values) if not names or info.name in names else (info.ports, t_ns, values)

    log = rewritten(tmp_path / "odd.mcap", changed)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # numpy's would be printed beside the command's own lines
        assert main(["report", str(log), "--json"]) == 0
        judged = main(["validity", str(log), "--json"])
    page, err = log.with_suffix(".html").read_text(), capsys.readouterr().err
    assert said in page
    assert "towline itself failed" not in err
    assert all(line.startswith("towline: ") for line in err.splitlines())
    assert judged == 0 or err.count("has no markers") == 1


def test_what_is_known_stays(tmp_path, capsys):
    """Numbers that are none for a third of the record change nothing at the other frames: equal statistics there."""
    cables = []
    for name, change in (("gap", at(third, np.nan)), ("cut", at(lambda k: np.r_[0 : k // 3, 2 * k // 3 : k]))):
        log = rewritten(tmp_path / f"{name}.mcap", change, ("markers",))
        assert main(["validity", str(log), "--json", "--noise", "0.4 mm"]) == 0
        cables.append(json.loads(capsys.readouterr().out)["cables"]["markers"])
    for key in ("alpha_deg", "e_plane_mm", "e_catenary_mm"):
        assert cables[0][key] == pytest.approx(cables[1][key], rel=1e-12)


def test_line_of_unknown_length_is_left_out(tmp_path, capsys):
    """Without a scenario nothing tells the length of a line that stands in one place: the page says so."""
    log = rewritten(tmp_path / "nowhere.mcap", at(everything, 0.0), scenario=False)
    assert main(["report", str(log), "--json"]) == 0
    assert "not judged: " in log.with_suffix(".html").read_text()
    assert main(["validity", str(log), "--json"]) == 1
    assert "length is not known, and no place on it; give --length" in capsys.readouterr().err


def test_log_that_is_being_written(tmp_path, capsys):
    """Before its first chunk nothing is in it; after that what there is, said to be unfinished; both in one line."""
    with open_log(SAMPLE) as log:
        specs = [ChannelSpec(name, info.ports, info.metadata) for name, info in log.channels.items()]
        rows = [pack_rows(*both) for both in log.read().values()]
    recorder = Recorder(tmp_path / "live.mcap", specs)
    assert main(["report", str(recorder.path)]) == 1
    assert re.search(r"live\.mcap is still being written, or was interrupted: nothing is in it yet", told(capsys))
    for i, some in enumerate(rows):
        recorder.rows(i, some[:60])
    recorder.flush()
    assert main(["report", str(recorder.path)]) == 0
    assert re.search(r"live\.mcap is still being written, or was interrupted: readable up to [\d.]+ s", told(capsys))
    os.utime(recorder.path, (0, 0))
    assert main(["validity", str(recorder.path), "--json"]) == 0
    assert "live.mcap was interrupted: readable" in told(capsys)
    recorder.abort()


def told(capsys) -> str:
    """The first line that a command said."""
    return capsys.readouterr().err.splitlines()[0]


def test_page_draws_components_of_ones_own(tmp_path):
    """Each port of a model that is a file, six curves of a large one at most; Towline's own models have no such tab."""
    ports = (Port("pull", "N", (3,), "NED"), Port("lean", "rad"), Port("profile", "m/s", (40,)))
    out = tmp_path / "own.mcap"
    with Recorder(out, [ChannelSpec("spring", ports, {"model": "/x/spring.py"})]) as recorder:
        recorder.rows(0, pack_rows(np.arange(5) * 10**9, np.full((5, 44), np.pi)))
    with open_log(out) as log, open_log(SAMPLE) as sample:
        found = others.tab(Signals(log))
        assert others.tab(Signals(sample)) is None
    charts = {item.title: item for item in found.items if not isinstance(item, str)}
    assert [series.name for series in charts["pull"].series] == ["north", "east", "down"]
    assert charts["lean"].axis == "lean [°]"
    assert charts["lean"].series[0].values == pytest.approx(180.0)
    assert [series.name for series in charts["profile"].series][:2] == ["profile[0]", "profile[8]"]
    assert len(charts["profile"].series) == 6


def test_page_draws_ports_of_an_fmu_once(tmp_path):
    """What another tab drew of a foreign model is not drawn again among the components of one's own."""
    ports = (Port("thrust", "N", (2,)), Port("wear", "1"))
    out = tmp_path / "foreign.mcap"
    with Recorder(out, [ChannelSpec("thrusters", ports, {"model": "/x/thrusters.fmu"})]) as recorder:
        recorder.rows(0, pack_rows(np.arange(5) * 10**9, np.ones((5, 3))))
    with open_log(out) as log:
        signals = Signals(log)
        known, found = thrusters.tab(signals), others.tab(signals)
    assert [item.title for item in known.items if not isinstance(item, str)] == ["Thrust of each thruster"]
    assert [item.title for item in found.items if not isinstance(item, str)] == ["wear"]
