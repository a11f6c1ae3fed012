"""What viewers are given of a log: lines, bodies, curves; the main scene's layout; the live WebSocket."""

import asyncio
import importlib.util
import json
import re
import socket
import struct
import sys
from pathlib import Path

import numpy as np
import pytest
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from mcap.reader import make_reader

from pipeline.cli import main
from pipeline.log.reader import open_log
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario
from pipeline.viewing.drawn import PERIOD_NS, drawn
from pipeline.viewing.live import Live
from pipeline.wiring import build_graph

ROOT = Path(__file__).parents[2]
SAMPLE = ROOT / "logs" / "sample.mcap"
needs_rerun = pytest.mark.skipif(
    importlib.util.find_spec("rerun") is None, reason="Rerun (extra `view`, 140 MB) is not installed"
)


def test_lines_bodies_and_curves():
    """East, north, up of what the log holds; angles in degrees; what tells of the solver is left aside."""
    with open_log(SAMPLE) as log:
        found = {one.channel.name: one for one in drawn(log)}
        ((port, places),) = found["tether"].lines()
        nodes = log.port("tether", "nodes")
        assert port.name == "nodes"
        assert np.array_equal(places[0, :, 0], nodes[0, :, 1])
        assert np.array_equal(places[-1, :, 2], -nodes[-1, :, 2])
        assert (np.diff(found["tether"].t_ns) >= PERIOD_NS).all()
        curves = {port.name: (names, values) for port, names, values in found["tether"].curves()}
    assert not [name for name in curves if name.startswith(("validity", "residual", "nodes"))]
    names, values = curves["tension"]
    assert names[0] == "tension[0]"
    assert values.shape == (len(found["tether"].t_ns), len(names))
    assert curves["force_a"][0] == ["north", "east", "down"]
    assert [port.name for port, _ in found["hand"].bodies()] == ["motion.position"]  # a point that moves by itself


def fields(path: Path) -> dict[str, dict[str, list[str]]]:
    """Of each channel, its messages' fields by message, as any reader of MCAP and protobuf sees them."""
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    found = {}
    for channel in summary.channels.values():
        schema = summary.schemas[channel.schema_id]
        messages = [m for f in FileDescriptorSet.FromString(schema.data).file for m in f.message_type]
        found[channel.topic] = {schema.name.rpartition(".")[2]: [m.name for m in messages]} | {
            f"{outer.name}.{field.name}": [inner.name for inner in of.field]
            for outer in messages
            for field in outer.field
            for of in [*outer.nested_type, *messages]
            if field.type_name.rpartition(".")[2] == of.name
        }
    return found


def test_layout_shows_what_the_main_scene_records(tmp_path):
    """Each message path of the layout leads to a channel, a field and a number that are there."""
    scenario = load_scenario(ROOT / "scenarios" / "dp_rov_tether.yaml", duration="2 s")
    log = run_scenario(scenario, build_graph(scenario), tmp_path / "scene.mcap", Options(), lambda _: None).log
    layout = json.loads((ROOT / "scenarios" / "viewers" / "dp_rov_tether.json").read_text())
    paths = [path["value"] for panel in layout["configById"].values() for path in panel.get("paths", ())]
    assert len(paths) > 8
    with open_log(log) as opened:
        for path in paths:
            channel, port, index = re.fullmatch(r"(\w+)\.([\w.]+)\[(\d+)\]", path).groups()
            assert opened.channel(channel).port(port)[0].size > int(index), path
            *outer, last = port.split(".")
            assert not outer or last in fields(Path(log))[channel][f"{channel}.{outer[0]}"], path
    topics = fields(Path(log)).keys()
    assert layout["configById"]["3D!scene"]["topics"].keys() <= topics


@pytest.mark.parametrize(
    ("package", "extra", "words"), [("rerun", "view", ["view", str(SAMPLE)]), ("foxglove", "live", ["run", "--live"])]
)
def test_absent_package_is_told(package, extra, words, monkeypatch, capsys, tmp_path):
    monkeypatch.setitem(sys.modules, package, None)
    if words[0] == "run":
        words = ["run", str(ROOT / "scenarios" / "van_der_pol.yaml"), "--out", str(tmp_path / "a.mcap"), "--live"]
    assert main(words) == 1
    assert f'is not installed; pip install -e ".[{extra}]"' in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("endpoint", ["8765", "127.0.0.1:", "127.0.0.1:99999", "127.0.0.1:x"])
def test_bad_endpoint(endpoint):
    with pytest.raises(Exception, match="expected HOST:PORT"):
        Live(endpoint, "test")


def test_address_of_version_6():
    pytest.importorskip("foxglove", reason="foxglove-sdk (extra `live`) is not installed")
    if not socket.has_ipv6:
        pytest.skip("this machine has no IPv6")
    server = Live("[::1]:0", "test")
    server.close()
    assert re.fullmatch(r"ws://\[::1\]:\d+", server.url)


def test_live_messages_are_those_of_the_log(tmp_path):
    """A viewer that speaks foxglove.sdk.v1 by websockets gets each message, with the log's bytes and times."""
    websockets = pytest.importorskip("websockets", reason="websockets (extra `dev`) is not installed")
    pytest.importorskip("foxglove", reason="foxglove-sdk (extra `live`) is not installed")
    server = Live("127.0.0.1:0", "test")
    scenario = load_scenario(ROOT / "scenarios" / "van_der_pol.yaml", duration="0.5 s")
    graph, out = build_graph(scenario), tmp_path / "live.mcap"

    async def watch() -> list[tuple[str, int, bytes]]:
        topics, found = {}, []
        run = asyncio.create_task(asyncio.to_thread(wait_and_run))
        async with await connected() as viewer:
            while not run.done():
                try:
                    message = await asyncio.wait_for(viewer.recv(), 1.0)
                except TimeoutError:
                    continue
                if isinstance(message, str):
                    told = json.loads(message)
                    if told["op"] == "advertise":
                        topics |= {one["id"]: one["topic"] for one in told["channels"]}
                        subscriptions = [{"id": one["id"], "channelId": one["id"]} for one in told["channels"]]
                        await viewer.send(json.dumps({"op": "subscribe", "subscriptions": subscriptions}))
                elif message[0] == 1:
                    number, t_ns = struct.unpack_from("<IQ", message, 1)
                    found.append((topics[number], t_ns, message[13:]))
            await run
        return found

    async def connected():
        """As viewers do, again and again until it serves."""
        while True:
            try:
                return await websockets.connect(server.url, subprotocols=["foxglove.sdk.v1"])
            except OSError:
                await asyncio.sleep(0.02)

    def wait_and_run() -> None:
        run_scenario(scenario, graph, out, Options(audience=server, rate=0.2), lambda _: None)

    try:
        found = asyncio.run(asyncio.wait_for(watch(), 60))
    finally:
        server.close()
    with open_log(out) as log:
        logged = [message for message in log.messages() if not message[0].startswith("/")]
    assert len(found) > 100
    assert {one[0] for one in logged} - {one[0] for one in found} <= {"towline/snapshots", "towline/events"}
    assert {one for one in found if not one[0].startswith("/")} <= set(logged)
    assert len(found) >= 0.5 * len(logged)  # the subscription comes some tenths of a second after the run's beginning


@needs_rerun
def test_recording_for_rerun(tmp_path):
    out = tmp_path / "sample.rrd"
    assert main(["view", str(SAMPLE), "--save", str(out)]) == 0
    assert out.stat().st_size > 10_000
    assert main(["view", str(SAMPLE), "--save", str(out)]) == 1
    assert main(["view", str(SAMPLE), "--at", "1"]) == 1


@needs_rerun
def test_neither_log_nor_recording_is_lost(tmp_path, capsys):
    """Not by a recording in the log's place, and not by a log that turns out to be damaged."""
    log, out = tmp_path / "own.mcap", tmp_path / "own.rrd"
    content = bytearray(SAMPLE.read_bytes())
    content[len(content) // 2 : len(content) // 2 + 200] = bytes(200)
    log.write_bytes(content)
    out.write_bytes(b"an older recording")
    for option in ("--save", "--screenshot"):
        assert main(["view", str(log), option, str(log), "--overwrite"]) == 1
        assert "is the log itself" in capsys.readouterr().err
    assert main(["view", str(log), "--save", str(out), "--overwrite"]) == 1
    assert "is damaged" in capsys.readouterr().err
    assert log.read_bytes() == content
    assert out.read_bytes() == b"an older recording"
    assert sorted(tmp_path.iterdir()) == [log, out]
