"""What a user's zenoh file may say, and what is refused with its place. Authority: zenoh's own reading of its keys."""

from __future__ import annotations

import json

import pytest

from pipeline.bus.configuration import configuration
from pipeline.errors import HostError

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
