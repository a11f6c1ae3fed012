"""Channels on the bus, from a log and from a run: the log's bytes and times, in its order.

Authority: the messages as the mcap library reads them from the log.
"""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
import zenoh
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass
from mcap.reader import make_reader

from pipeline.bus.channels import CHANNELS, SCHEMAS, simulated_ns
from pipeline.bus.configuration import configuration
from pipeline.cli import main
from pipeline.errors import TowlineError
from pipeline.hosts.deployment import BusOptions
from pipeline.log.reader import open_log
from pipeline.playback import Player
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph

ROOT = Path(__file__).parents[2]
SCENARIO = load_scenario(ROOT / "scenarios" / "bond_mass.yaml", duration="2 s")
LIMIT_S = 60.0


def run(path: Path, bus: BusOptions | None = None, progress=lambda _: None):
    return run_scenario(SCENARIO, build_graph(SCENARIO), path, Options(bus=bus), progress)


@pytest.fixture(scope="module")
def log(tmp_path_factory) -> Path:
    """Every kind of channel: components, a bond, drawings, events, snapshots."""
    path = tmp_path_factory.mktemp("log") / "a.mcap"
    run(path)
    return path


@pytest.fixture
def endpoint() -> str:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


def by_mcap(path: Path) -> list[tuple[str, int, bytes]]:
    with path.open("rb") as file:
        reader = make_reader(file)
        return [(c.topic.lstrip("/"), m.log_time, m.data) for _, c, m in reader.iter_messages(log_time_order=False)]


@dataclass
class Subscriber:
    """What came to a third party that listens to all channels: topic, simulated time, bytes; and wall times."""

    endpoint: str
    messages: list[tuple[str, int, bytes]] = field(default_factory=list)
    wall_s: list[float] = field(default_factory=list)
    encodings: dict[str, str] = field(default_factory=dict)

    def note(self, sample: zenoh.Sample) -> None:
        self.wall_s.append(time.monotonic())
        topic = str(sample.key_expr).removeprefix(f"{CHANNELS}/")
        self.encodings[topic] = str(sample.encoding)
        self.messages.append((topic, simulated_ns(sample.attachment.to_bytes()), sample.payload.to_bytes()))


@contextmanager
def subscribed(endpoint: str, *, is_listening: bool = False) -> Iterator[tuple[Subscriber, zenoh.Session]]:
    listen, connect = ([endpoint], []) if is_listening else ([], [endpoint])
    session, subscriber = zenoh.open(configuration(listen, connect)), Subscriber(endpoint)
    try:
        handle = session.declare_subscriber(f"{CHANNELS}/**", subscriber.note)
        yield subscriber, session
        handle.undeclare()
    finally:
        session.close()


def until(is_true) -> None:
    deadline = time.monotonic() + LIMIT_S
    while not is_true():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_log_gives_its_messages_in_order(log):
    found = [(topic.lstrip("/"), t_ns, data) for topic, t_ns, data in open_log(log).messages()]
    assert found == by_mcap(log)


def test_whole_log_on_the_bus(log, endpoint, capsys):
    """By the command: the same bytes, times and order; at twice the rate, 2 s take one."""
    with subscribed(endpoint, is_listening=True) as (subscriber, _):
        words = ["replay", str(log), "--bus", "zenoh", "--connect", endpoint, "--wait", "--rate", "2", "--json"]
        assert main(words) == 0
        expected = by_mcap(log)
        until(lambda: len(subscriber.messages) == len(expected))
    for topic in {topic for topic, _, _ in expected}:  # zenoh keeps the order of each key
        assert [m for m in subscriber.messages if m[0] == topic] == [m for m in expected if m[0] == topic]
    # A busy machine can delay any single message at will; the median of all is bounded, by a tenth of the whole.
    due_s = np.array([t_ns for _, t_ns, _ in subscriber.messages]) / 1e9 / 2
    late_s = np.array(subscriber.wall_s) - subscriber.wall_s[0] - due_s
    assert abs(float(np.median(late_s))) < 0.1
    assert '"messages": ' + str(len(expected)) in capsys.readouterr().out


def test_messages_are_never_put_before_their_time(log, monkeypatch):
    """With a clock of the test's own, that sleep moves and each message by a millisecond."""
    now, put = [100.0], []

    class Audience:
        def declare(self, topic, message, descriptors) -> None:
            pass

        def is_wanted(self, topic) -> bool:
            return True

        def put(self, topic, t_ns, payload) -> None:
            put.append((now[0] - 100.0, t_ns))
            now[0] += 0.001

    monkeypatch.setattr("pipeline.playback.time.monotonic", lambda: now[0])
    monkeypatch.setattr("pipeline.playback.time.sleep", lambda s: now.__setitem__(0, now[0] + s))
    player = Player(open_log(log), Audience(), rate=0.1)
    player.play(1_000_000_000)
    late_s = np.array([wall_s - 10 * t_ns / 1e9 for wall_s, t_ns in put])
    most_at_once = max(np.unique([t_ns for _, t_ns in put], return_counts=True)[1])
    assert late_s.min() > -1e-9  # rounding of seconds
    assert late_s.max() < 0.001 * most_at_once
    assert player.played.worst_late_s == pytest.approx(late_s.max(), abs=1e-9)
    assert max(t_ns for _, t_ns in put) == 1_000_000_000


def test_schemas_by_query(log, endpoint):
    """They decode the messages, to the numbers that the log gives."""
    words = [sys.executable, "-m", "pipeline.cli", "replay", str(log), "--bus", "zenoh", "--listen", endpoint, "--loop"]
    child = subprocess.Popen([*words, "--until", "500 ms", "--rate", "10"], cwd=ROOT, stderr=subprocess.PIPE, text=True)
    try:
        with subscribed(endpoint) as (subscriber, session):
            expected = open_log(log)
            until(lambda: set(subscriber.encodings) >= set(expected.channels))
            replies = {}
            for reply in session.get(f"{SCHEMAS}/**"):
                topic = str(reply.ok.key_expr).removeprefix(f"{SCHEMAS}/")
                replies[topic] = reply.ok.attachment.to_bytes().decode(), reply.ok.payload.to_bytes()
            count = len(subscriber.messages)
            until(lambda: len(subscriber.messages) > 2 * count)  # it loops
        child.send_signal(signal.SIGINT)
        _, err = child.communicate(timeout=LIMIT_S)
    finally:
        child.kill()
    assert (child.returncode, err.splitlines()[-1]) == (130, "towline: interrupted")
    assert replies == {topic.lstrip("/"): (one.message, one.descriptors) for topic, one in expected.schemas().items()}
    name, data = replies["ball"]
    assert subscriber.encodings["ball"] == f"application/protobuf;{name}"
    pool = DescriptorPool()
    for file in FileDescriptorSet.FromString(data).file:
        pool.Add(file)
    message = GetMessageClass(pool.FindMessageTypeByName(name))
    times, values = expected.times("ball").tolist(), expected.port("ball", "hook.position")
    found = [(t_ns, message.FromString(sent)) for topic, t_ns, sent in subscriber.messages if topic == "ball"]
    assert all(list(one.hook.position) == values[times.index(t_ns)].tolist() for t_ns, one in found)
    assert max(t_ns for t_ns, _ in found) <= 500_000_000


def test_third_party_during_a_distributed_run(log, endpoint, tmp_path):
    """It gets the bytes that the run's log has, from when it has joined, and changes nothing."""
    subscribers = []

    def join(simulated_s: float) -> None:
        if not subscribers and simulated_s > 0.2:
            manager = subscribed(endpoint)
            subscribers.append((manager, *manager.__enter__()))
            until(lambda: publishes(subscribers[0][2]))

    path = tmp_path / "b.mcap"
    result = run(path, BusOptions((endpoint,)), join)
    manager, subscriber, _ = subscribers[0]
    manager.__exit__(None, None, None)
    assert result.digest == open_log(log).metadata("result")["digest"]
    expected = by_mcap(path)
    topics = set(open_log(path).channels)
    assert topics <= set(subscriber.encodings)
    for topic in topics | {"towline/events"}:
        came = [m for m in subscriber.messages if m[0] == topic]
        assert came == [m for m in expected if m[0] == topic][-len(came) :]
        assert len(came) > 50 or topic == "towline/events"


def publishes(session: zenoh.Session) -> bool:
    """Whether a session has met the run's."""
    return bool(list(session.info.peers_zid()))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--bus", "zenoh", "--until", "3 kg"], "--until: "),
        (["--bus", "zenoh", "--set", "ball.mass=2"], "--set and --out belong to --component"),
        (["--bus", "zenoh", "--listen", "tcp/300.1.1.1:1"], "zenoh cannot be started: "),
    ],
)
def test_refused(words, said, log, capsys):
    assert main(["replay", str(log), *words]) == 1
    assert capsys.readouterr().err.startswith(f"towline: {said}")


def test_damaged_count_is_told(log, monkeypatch):
    opened = open_log(log)
    monkeypatch.setattr(opened, "_count", 7)
    with pytest.raises(TowlineError, match="of 7 messages are there"):
        list(opened.messages())
