"""Scenes whose components are FMUs of other scenes give the native scenes' bits, wire by wire."""

import errno
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

from pipeline.analysis.recording import recordings
from pipeline.analysis.validity import Tolerance, judge
from pipeline.errors import ScenarioError, TowlineError
from pipeline.fmu.cached import cached_fmu
from pipeline.log.reader import open_log
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario, load_scenario_text
from pipeline.wiring import build_graph

SCENARIOS = Path(__file__).parents[2] / "scenarios"


def rows(name, path, duration="8 s"):
    scenario = load_scenario(SCENARIOS / f"{name}.yaml", duration=duration)
    graph = build_graph(scenario)
    result = run_scenario(scenario, graph, path, Options(), lambda _: None)
    log = open_log(result.log)
    return {
        f"{node.name}.{port.name}": log.port(node.name, port.name)
        for node in graph.nodes
        for port in node.outputs
        if not port.name.startswith("validity")  # an FMU has these as ports too, but its parameters may leave some out
    }


@pytest.mark.parametrize(("name", "native"), [("boom_fmu", "boom_sweep"), ("dp_fmu", "supply_vessel_box")])
def test_bits_of_the_native_scene(name, native, tmp_path):
    found, expected = rows(name, tmp_path / "fmu.mcap"), rows(native, tmp_path / "native.mcap")
    assert found.keys() == expected.keys()
    for port, value in expected.items():
        assert np.array_equal(found[port].reshape(value.shape), value), port


def test_a_line_that_is_an_fmu_is_judged_as_the_native_one(tmp_path):
    """Its length, weight and drag are constants of the FMU, which the log holds: the same verdict to the last bit."""
    verdicts = []
    for name in ("boom_fmu", "boom_sweep"):
        rows(name, tmp_path / f"{name}.mcap", "2 s")
        (recording,) = recordings(tmp_path / f"{name}.mcap")
        found = judge(recording, "fast", Tolerance(0.01, True)).line
        assert found is not None, name
        verdicts.append((found.line.square, {key: match.as_json() for key, match in found.matches.items()}))
    assert verdicts[0] == verdicts[1]
    assert verdicts[0][1]["mean_load"]["verdict"] == "holds"


@pytest.mark.parametrize(
    ("reference", "message"),
    [
        ("boom_sweep.yaml#rope", "no component 'rope'"),
        ("absent.yaml#boom", "absent.yaml"),
        ("boom_fmu.yaml#boom", "FMU"),
    ],
)
def test_a_reference_that_leads_nowhere(reference, message):
    text = f"duration: 1 s\nstep: 50 ms\ncomponents:\n  boom: {{fmu: '{reference}'}}\n"
    with pytest.raises(ScenarioError, match=message) as caught:
        load_scenario_text(text, "own.yaml", SCENARIOS)
    assert "own.yaml:4:15 components.boom.fmu" in str(caught.value)


def test_a_scene_made_of_itself(tmp_path):
    path = tmp_path / "own.yaml"
    path.write_text("duration: 1 s\nstep: 50 ms\ncomponents:\n  boom: {fmu: 'own.yaml#boom'}\n")
    with pytest.raises(ScenarioError, match="is made of itself"):
        load_scenario(path)


SPRING = """
import sys
sys.path.insert(0, {folder!r})
from gain_beside import GAIN
from components.contract import HEADER, Component, Parameters, Port, quantity

class Spring(Parameters):
    stiffness: float = quantity("N/m", "k", gt=0)

def init(t_ns, dt_ns, p, u, x, y, w):
    return 0

def step(t_ns, dt_ns, p, u, x, y, w):
    y[0] = -GAIN * p[HEADER] * u[0]
    return 0

COMPONENT = Component(
    name="own_spring",
    parameters=Spring,
    inputs=lambda _: (Port("place", "m"),),
    outputs=lambda _: (Port("force", "N"),),
    init=init,
    step=step,
)
"""
SCENE = """
duration: 1 s
step: 50 ms
components: {spring: {model: ./own spring.py, parameters: {stiffness: 8 N/m}, inputs: {place: 1 m}}}
"""


def test_an_own_component_is_built_anew_when_a_file_beside_it_changes(tmp_path, monkeypatch):
    """As runs without an FMU compile it anew; what is damaged in the cache is built anew too."""
    monkeypatch.setattr(sys, "path", [*sys.path])
    (tmp_path / "own spring.py").write_text(SPRING.format(folder=str(tmp_path)))
    (tmp_path / "own scene.yaml").write_text(SCENE)

    def built(gain):
        (tmp_path / "gain_beside.py").write_text(f"GAIN = {gain}\n")
        for name in [one for one in sys.modules if one.startswith(("gain_beside", "towline_model_own spring"))]:
            monkeypatch.delitem(sys.modules, name)  # as in a new process
        return cached_fmu(tmp_path, "own scene.yaml#spring")

    first = built(1.0)
    archive = first.read_bytes()
    second = built(2.05)
    assert second.read_bytes() != archive
    assert built(1.0) == first
    first.write_bytes(archive[:1000])
    assert built(1.0).read_bytes() == archive
    for path in (first, second):
        path.unlink()


# Instead of building, which takes seconds, each brings the same archive, and waits for the other to have done so.
AT_ONCE = """
import io, os, sys, time, zipfile
from pathlib import Path
from pipeline.fmu import build, cached

folder, scenes = Path(sys.argv[1]), Path(sys.argv[2])
cached.cache_folder = lambda: folder

def together(*_):
    (folder / f"built-{os.getpid()}").touch()
    while len(list(folder.glob("built-*"))) < 2:
        time.sleep(0.01)
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr(zipfile.ZipInfo("large"), bytes(1 << 24))
    return archive.getvalue()

build.build = together
print(cached.cached_fmu(scenes, "van_der_pol.yaml#a"))
"""


def test_two_processes_build_one_fmu_at_once(tmp_path):
    """Both have built it before either keeps it: both get the same whole file, and nothing else is left."""
    words = [sys.executable, "-c", AT_ONCE, str(tmp_path), str(SCENARIOS)]
    both = [subprocess.Popen(words, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    paths = {process.communicate(timeout=120)[0].strip() for process in both}
    assert [process.returncode for process in both] == [0, 0]
    (path,) = paths
    with zipfile.ZipFile(path) as archive:
        assert archive.testzip() is None
    assert [one.name for one in (tmp_path / "fmus").iterdir()] == [Path(path).name]


@pytest.mark.parametrize("fault", ["no folder", "full"])
def test_an_fmu_that_cannot_be_kept(fault, tmp_path, monkeypatch):
    """Where the FMUs' folder cannot be made, or the disk is full amid one: one line, and no half of it is left."""

    def full(path, data):
        with open(path, "wb") as file:
            file.write(data[:10])
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("pipeline.fmu.cached.cache_folder", lambda: tmp_path)
    monkeypatch.setattr("pipeline.fmu.build.build", lambda *_: bytes(1000))
    if fault == "no folder":
        (tmp_path / "fmus").write_text("a file")
    else:
        monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(TowlineError, match=r"the FMU cannot be kept: .*; mend that, or set TOWLINE_CACHE"):
        cached_fmu(SCENARIOS, "van_der_pol.yaml#a")
    assert fault == "no folder" or not list((tmp_path / "fmus").iterdir())


def test_a_file_with_the_sign_of_references_in_its_name(tmp_path):
    text = "duration: 1 s\nstep: 50 ms\ncomponents:\n  boom: {fmu: 'no#1.fmu'}\n"
    with pytest.raises(ScenarioError, match=r"no#1\.fmu cannot be read"):
        load_scenario_text(text, "own.yaml", tmp_path)
