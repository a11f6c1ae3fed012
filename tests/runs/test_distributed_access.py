"""Rules of zenoh's access control in a bus configuration are in force. Authority: zenoh's manual; the local digest.

The users are a machine, which may take part, and a viewer, which may listen to channels. Without rules, the viewer's
messages in the names of others are ignored and counted; with them, none gets there.
"""

from __future__ import annotations

import json
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import zenoh

from pipeline.bus.configuration import close_session, configuration
from pipeline.bus.identity import Identity
from pipeline.bus.zenoh import ConductorBus
from pipeline.hosts.deployment import BusOptions
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

ROOT = Path(__file__).parents[2]
TEXT = """
duration: 2 s
step: 10 ms
hosts: {b: crane}
machines: {crane: {limit: 30 s}}
components:
  a: {model: motion.van_der_pol, inputs: {neighbour: {from: b.position, delay: true}}}
  b: {model: motion.van_der_pol, inputs: {neighbour: a.position}}
"""
ALL = ["put", "declare_subscriber", "liveliness_token", "declare_liveliness_subscriber", "liveliness_query"]
LIMIT_S = 60.0


def rule(name: str, messages: list[str], flows: list[str], *keys: str) -> dict:
    return {"id": name, "permission": "allow", "messages": messages, "flows": flows, "key_exprs": list(keys)}


RULES = {
    "enabled": True,
    "default_permission": "deny",
    "rules": [
        rule("everything", ALL, ["ingress", "egress"], "towline/**"),
        rule("to ask for channels", ["declare_subscriber"], ["ingress"], "towline/channel/**"),
        rule("to be sent them", ["put"], ["egress"], "towline/channel/**"),
    ],
    "subjects": [
        {"id": "this machine", "link_protocols": ["unixsock-stream"]},
        {"id": "machines", "usernames": ["crane"]},
        {"id": "viewers", "usernames": ["viewer"]},
    ],
    "policies": [
        {"subjects": ["this machine", "machines"], "rules": ["everything"]},
        {"subjects": ["viewers"], "rules": ["to ask for channels", "to be sent them"]},
    ],
}


def bus_file(folder: Path, user: str, **more) -> Path:
    """A configuration with user and password."""
    login = {"user": user, "password": f"{user}'s"}
    if more:
        (folder / "users.txt").write_text("".join(f"{name}:{name}'s\n" for name in ("conductor", "crane", "viewer")))
        login["dictionary_file"] = "users.txt"
    path = folder / f"{user}.json"
    path.write_text(json.dumps({"transport": {"auth": {"usrpwd": login}}, **more}))
    return path


@contextmanager
def crane(endpoint: str, config: Path) -> Iterator[None]:
    words = ["host", "--connect", endpoint, "--name", "crane", "--bus-config", str(config)]
    child = subprocess.Popen(
        [sys.executable, "-m", "pipeline.cli", *words], cwd=ROOT, stderr=subprocess.PIPE, stdout=subprocess.PIPE
    )
    try:
        yield
    finally:
        child.kill()
        child.communicate(timeout=LIMIT_S)


class Viewer:
    """Listens to a channel, sends in the names of conductor and hosts, and offers itself as a host."""

    def __init__(self, endpoint: str, config: Path, keys: list[str]):
        made = configuration([], [endpoint], config)
        made.insert_json5("mode", '"client"')  # zenoh passes a client's messages on to other machines
        self._session, self._keys, self._is_over = zenoh.open(made), keys, threading.Event()
        self.heard: list[str] = []
        self.subscriber = self._session.declare_subscriber(
            "towline/channel/**", lambda sample: self.heard.append(str(sample.key_expr))
        )
        self.token = self._session.liveliness().declare_token(f"towline/host/a/{Identity().name}")
        self._thread = threading.Thread(target=self._send)
        self._thread.start()

    def _send(self) -> None:
        while not self._is_over.wait(0.01):
            for key in self._keys:
                self._session.put(key, b"not of this run")

    def close(self) -> None:
        self._is_over.set()
        self._thread.join()
        close_session(self._session)


@pytest.mark.parametrize("has_rules", [True, False])
def test_viewer_that_sends_in_other_names(has_rules, tmp_path, monkeypatch):
    keys: list[str] = []
    attach = ConductorBus.attach

    def attached(self: ConductorBus, host: str, process: str) -> None:
        attach(self, host, process)
        keys.extend((f"towline/out/{host}/{process}", f"towline/in/{host}/{process}/{self._identity.name}"))

    monkeypatch.setattr(ConductorBus, "attach", attached)
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        endpoint = f"tcp/127.0.0.1:{probe.getsockname()[1]}"
    rules = {"access_control": RULES} if has_rules else {"access_control": {"enabled": False}}
    conductor, machine = bus_file(tmp_path, "conductor", **rules), bus_file(tmp_path, "crane")
    scenario = load_scenario_text(TEXT, "access.yaml", ROOT / "scenarios")
    graph, viewers, said = build_graph(scenario), [], []

    def join(_: float) -> None:
        if not viewers:
            viewers.append(Viewer(endpoint, bus_file(tmp_path, "viewer"), keys))
        time.sleep(0.01)

    options = Options(bus=BusOptions((endpoint,), conductor), tell=said.append, slice_ticks=2)
    try:
        with crane(endpoint, machine):
            result = run_scenario(scenario, graph, tmp_path / "a.mcap", options, join)
    finally:
        for viewer in viewers:
            viewer.close()
    local = run_scenario(scenario, graph, tmp_path / "local.mcap", Options(), lambda _: None)
    assert result.digest == local.digest
    assert {"towline/channel/a", "towline/channel/b"} <= set(viewers[0].heard)
    intruded = [line for line in said if "ignored" in line]
    if has_rules:
        assert not intruded
        assert all(counts["refused"] == 0 for counts in result.hosts.values())
    else:
        assert any("another process offers itself as a" in line for line in intruded)
        assert all(counts["refused"] > 10 for counts in result.hosts.values())
