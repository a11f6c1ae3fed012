"""What a user's zenoh file may say, and what is refused with its place. Authority: zenoh's own reading of its keys."""

from __future__ import annotations

import json
from argparse import Namespace
from dataclasses import replace
from pathlib import Path

import psutil
import pytest

from pipeline.bus.configuration import close_session, configuration, open_session
from pipeline.commands.run import bus_of
from pipeline.errors import HostError, TowlineError
from pipeline.hosts.deployment import BusOptions
from pipeline.placement import Hosts
from pipeline.scenario import load_scenario_text

WRONG = {
    "{transport: {auth: {usrpwd: {user: 'a', passwort: 'b'}}}}": r":1:41 unknown field `passwort`, .*`password`",
    "not json {": ":1:1 expected array, boolean, null, number, object, or string",
    "{listen: {endpoints: ['tcp/0.0.0.0:7447']}}": ": listen cannot be set here: use --listen",
    "{connect: {endpoints: ['tcp/10.0.0.1:7447']}}": ": connect cannot be set here: use --connect",
    "{mode: 'router'}": ": mode cannot be set here: towline sets it itself",
    "{scouting: {multicast: {enabled: true}}}": ": scouting cannot be set here: towline sets it itself",
    "{transport: {link: {tls: {root_ca_certificate: 'ca.pem'}}}}": (
        r": transport.link.tls.root_ca_certificate: .*/ca.pem: No such file or directory"
    ),
    "{transport: {auth: {usrpwd: {dictionary_file: 'users'}}}}": ": transport.auth.usrpwd has a dictionary of users",
}


@pytest.mark.parametrize("text", WRONG)
def test_refused_in_one_line(text, tmp_path):
    file = tmp_path / "bus.json5"
    file.write_text(text)
    (tmp_path / "users").write_text("a:b\n")
    with pytest.raises(HostError, match=WRONG[text]) as error:
        configuration([], [], file)
    assert str(error.value).startswith(str(file))
    assert "\n" not in str(error.value)
    assert ".rs" not in str(error.value)


@pytest.mark.parametrize("name", ["missing.json5", "."])
def test_no_file(name, tmp_path):
    with pytest.raises(HostError, match=r"no zenoh configuration: .*(No such file|directory)"):
        configuration([], [], tmp_path / name)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        (
            "bus.json5",
            "{transport: {auth: {usrpwd: {user: 'a', password: 'b'}}, link: {tls: {connect_certificate: 'c'}}}}",
        ),
        ("bus.yaml", "transport: {auth: {usrpwd: {user: a, password: b}}, link: {tls: {connect_certificate: c}}}"),
    ],
)
def test_merged_under_ours(name, text, tmp_path):
    """Files that it names are relative to it."""
    (tmp_path / name).write_text(text)
    (tmp_path / "c").write_text("")
    config = configuration(["tcp/127.0.0.1:1"], [], tmp_path / name)
    assert json.loads(config.get_json("transport/auth/usrpwd/user")) == "a"
    assert json.loads(config.get_json("transport/link/tls/connect_certificate")) == str(tmp_path / "c")
    assert json.loads(config.get_json("listen/endpoints")) == ["tcp/127.0.0.1:1"]
    assert json.loads(config.get_json("scouting/multicast/enabled")) is False


def options(**given) -> Namespace:
    return Namespace(**{"bus": None, "listen": None, "bus_config": None} | given)


def test_endpoints_are_loopback_unless_said():
    """Without machines there are none but the socket; with machines, one of the loopback."""
    text = "duration: 1 s\nstep: 1 s\nbus: zenoh\ncomponents: {a: {model: motion.van_der_pol, inputs: {neighbour: 0}}}"
    alone = load_scenario_text(text, "a.yaml", Path.cwd())
    assert bus_of(options(), alone) == BusOptions(())
    assert bus_of(options(), replace(alone, hosts=Hosts({"a": "b"}, {"b": 1}))) == BusOptions(("tcp/127.0.0.1:7447",))
    assert bus_of(options(listen=["tcp/0.0.0.0:1"]), alone) == BusOptions(("tcp/0.0.0.0:1",))
    assert bus_of(options(bus="local"), alone) is None
    with pytest.raises(TowlineError, match="--listen and --bus-config need --bus zenoh"):
        bus_of(options(bus="local", listen=["tcp/0.0.0.0:1"]), alone)


@pytest.mark.parametrize("listen", [[], ["tcp/127.0.0.1:0"]])
def test_sockets_that_a_session_opens(listen):
    """No multicast: what it listens at, and nothing else. Authority: the operating system."""
    before = sockets()
    session = open_session(configuration(listen, []))
    try:
        assert [(c.laddr.ip, c.status) for c in sockets() - before] == [("127.0.0.1", "LISTEN")] * len(listen)
    finally:
        close_session(session)


def sockets() -> set:
    return set(psutil.Process().net_connections("inet"))


def test_endpoint_that_is_none():
    with pytest.raises(HostError, match=r'^\["here"\]: no endpoints; expected such as tcp/10.0.0.1:7447$'):
        configuration(["here"], [])
