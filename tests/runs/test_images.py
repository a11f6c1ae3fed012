"""Runs with images: in one process, over zenoh with a host killed, resumed, replayed and read from the log.

Authority: the local run's digest; the wall that the camera draws, computed here again; Pillow as decoder of PNG, and
mcap with protobuf alone as readers.
"""

from __future__ import annotations

import json
import os
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass
from mcap.reader import make_reader
from PIL import Image

from pipeline import run as run_module
from pipeline.cli import main
from pipeline.diff import diff_logs
from pipeline.hosts.deployment import BusOptions
from pipeline.log.reader import open_log
from pipeline.replay import replay_component
from pipeline.rerun import graph_of
from pipeline.resume import last_snapshot, resume_run
from pipeline.run import Options, Result, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

MODELS = Path(__file__).parents[1] / "orchestration" / "components"
# Grey and colour, direct and delayed, three rates, and a picture that is given on; host b has three sections, of which
# two are stepped at once.
SCENARIO = f"""
duration: 8 s
step: 10 ms
hosts: {{mark: b, cam: b, gauge: a, late: b, eye: b, seen: b}}
components:
  mark: {{model: motion.van_der_pol, inputs: {{neighbour: {{from: gauge.row, gain: 0.01 1/pixel, delay: true}}}}}}
  cam: {{model: {MODELS}/camera.py, period: 60 ms, inputs: {{height: mark.position}}}}
  gauge: {{model: {MODELS}/gauge.py, period: 20 ms, inputs: {{picture: cam.image}}}}
  late: {{model: {MODELS}/gauge.py, period: 40 ms, inputs: {{picture: {{from: cam.image, delay: true}}}}}}
  eye:
    model: {MODELS}/camera.py
    period: 60 ms
    parameters: {{is_color: true}}
    inputs: {{height: {{from: mark.position, gain: -1}}}}
  seen: {{model: {MODELS}/gauge.py, period: 60 ms, parameters: {{shape: [37, 51, 3]}}, inputs: {{picture: eye.image}}}}
events: [{{at: 4 s, set: {{cam.scale: 9}}}}]
"""


KILLED_NS = 5_520_000_000  # 92 images after t0


def run(path: Path, options: Options, text: str = SCENARIO) -> Result:
    scenario = load_scenario_text(text, "images.yaml", MODELS)
    return run_scenario(scenario, build_graph(scenario), path, options, lambda _: None)


@pytest.fixture(scope="module")
def local(tmp_path_factory) -> Result:
    """The undisturbed run in one process, with a snapshot at every block end."""
    flush_s, run_module.FLUSH_S = run_module.FLUSH_S, 0.0
    try:
        return run(tmp_path_factory.mktemp("images") / "local.mcap", Options())
    finally:
        run_module.FLUSH_S = flush_s


def wall(number: int, height: float, scale: float) -> np.ndarray:
    """What the camera sees in its image of this number, counted from 1 at t0."""
    row, column = np.mgrid[:37, :51]
    mark = np.abs(row - 18.5 - scale * height) < 2.5
    return np.where(mark, 255, (column * 7 + row * 3 + number) % 200).astype(np.uint8)


def test_log_is_read_by_others(local):
    """Every image decodes to the wall at its time, in both kinds of camera."""
    seen: dict[str, list[tuple[int, object]]] = {}
    with open(local.log, "rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            if channel.topic.startswith(("/image/", "mark")):
                pool = DescriptorPool()
                for described in FileDescriptorSet.FromString(schema.data).file:
                    pool.Add(described)
                kind = GetMessageClass(pool.FindMessageTypeByName(schema.name))
                seen.setdefault(channel.topic, []).append((message.log_time, kind.FromString(message.data)))
    position = {t_ns: mark.position for t_ns, mark in seen["mark"]}
    for topic, sign in (("/image/cam.image", 1.0), ("/image/eye.image", -1.0)):
        assert len(seen[topic]) == 134
        for number, (t_ns, image) in enumerate(seen[topic], 1):
            assert (image.format, image.frame_id) == ("png", "lens")
            assert image.timestamp.ToNanoseconds() == t_ns == (number - 1) * 60_000_000
            scale = 9.0 if sign > 0 and t_ns > 4_000_000_000 else 8.0
            grey = wall(number, sign * position[t_ns], scale)
            expected = grey if sign > 0 else np.stack([grey, 255 - grey, grey // 2], axis=2)
            assert np.array_equal(np.asarray(Image.open(BytesIO(image.data))), expected), f"{topic} at {t_ns}"


def test_log_is_read_back(local):
    with open_log(local.log) as log:
        images = list(log.images("eye", "image"))
        assert len(images) == 134
        assert images[0][1].shape == (37, 51, 3)
        assert images[0][1][0, 1].tolist() == [8, 247, 4]  # (7 + 1, 255 - 8, 8 // 2): red, green, blue
        halves = {t_ns: half for t_ns, half in log.images("gauge", "half")}
        assert all(np.array_equal(halves[t_ns], image[::2, ::2]) for t_ns, image in log.images("cam", "image"))


def test_over_zenoh_with_a_killed_host(local, tmp_path):
    """The host of both cameras dies in a step of one; what they had drawn and seen is restored, to the same digest."""
    mark = tmp_path / "killed"
    dies = f"t_ns == {KILLED_NS} and os.getpid() != {os.getpid()} and not Path({str(mark)!r}).exists()"
    kill = f"    if {dies}:\n        Path({str(mark)!r}).touch()\n        os.kill(os.getpid(), 9)\n    return 0\n"
    source = (MODELS / "camera.py").read_text().replace("    return 0\n", kill)
    (tmp_path / "camera.py").write_text(
        source.replace("import numpy", "import os\nfrom pathlib import Path\n\nimport numpy")
    )
    text = SCENARIO.replace(f"{MODELS}/camera.py", f"{tmp_path}/camera.py")
    result = run(tmp_path / "zenoh.mcap", Options(bus=BusOptions()), text)
    assert mark.exists()
    assert result.hosts["b"]["restarts"] == 1
    assert result.digest == local.digest
    with open_log(local.log) as a, open_log(result.log) as b:
        assert diff_logs(a, b).identical


def test_resumed_after_a_crash(local, tmp_path):
    """From what is in the file of a run that died: images of the past are copied, the board's are in the snapshot."""
    data = Path(local.log).read_bytes()
    torn = tmp_path / "torn.mcap"
    torn.write_bytes(data[: int(0.85 * len(data))])
    with open_log(torn) as log:
        assert not log.complete
        assert last_snapshot(log).tick == 512  # 5.12 s, a block's end
        scenario, graph = graph_of(log)
        cam = next(node for node in graph.nodes if node.name == "cam")
        replay = replay_component(log, graph, cam)
        assert replay.identical
        assert len(replay.times_ns) == log.image_count("cam", "image") > 85  # those up to 5.12 s
        result = resume_run(log, scenario, graph, tmp_path / "whole.mcap", Options(), lambda _: None)
    assert result.digest == local.digest
    with open_log(local.log) as a, open_log(result.log) as b:
        assert diff_logs(a, b).identical


@pytest.mark.parametrize("component", ["mark", "cam", "gauge", "late", "eye", "seen"])
def test_replayed(local, component, tmp_path, capsys):
    assert main(["replay", local.log, "--component", component, "--out", str(tmp_path / "new.mcap"), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["identical"] is True
    assert all(port["max_abs"] == 0.0 for port in said["ports"].values())
    with open_log(local.log) as a, open_log(tmp_path / "new.mcap") as b:
        channels = diff_logs(a, b).channels
        mine = [name for name in channels if name == component or name.startswith(f"/image/{component}.")]
        assert len(mine) == 1 + (component != "mark")
        assert all(channels[name].max_abs == 0.0 and channels[name].times_equal for name in mine)


def test_what_changes_is_told(local, tmp_path, capsys):
    """Another parameter changes pixels, which replay and diff tell in grey levels; another size is no comparison."""
    new = tmp_path / "new.mcap"
    changed = ["replay", local.log, "--component", "cam", "--set", "cam.scale=3", "--out", str(new), "--json"]
    assert main(changed) == 0
    assert json.loads(capsys.readouterr().out)["ports"]["image"]["max_abs"] > 0.0
    assert main(["diff", local.log, str(new), "--json"]) == 1
    said = json.loads(capsys.readouterr().out)["channels"]
    assert said["cam"]["max_abs"] == 0.0  # its clock
    assert 0.0 < said["/image/cam.image"]["max_abs"] <= 255.0
    assert said["/image/eye.image"]["port_differences"] == ["only in a"]
    new.unlink()
    assert main(["replay", local.log, "--component", "cam", "--set", "cam.width=60", "--out", str(new), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["ports"]["image"]["max_abs"] is None
    assert main(["diff", local.log, str(new), "--json"]) == 1
    said = json.loads(capsys.readouterr().out)["channels"]
    assert said["/image/cam.image"]["port_differences"] == [
        "image [pixel] (37, 51) lens in a, image [pixel] (37, 60) lens in b"
    ]


def test_check_tells_images(tmp_path, capsys):
    (tmp_path / "images.yaml").write_text(SCENARIO)
    assert main(["check", str(tmp_path / "images.yaml"), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)["components"]
    assert said["eye"]["images"] == {"image": [37, 51, 3]}
    assert "images" not in said["mark"]


def test_no_fmu_has_images(tmp_path, capsys):
    assert main(["fmu", "build", f"{MODELS}/camera.py", "--out", str(tmp_path / "camera.fmu")]) == 1
    assert "test.camera is a Python callable; an FMU is made of compiled components only" in capsys.readouterr().err
