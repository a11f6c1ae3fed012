"""The zenoh configuration of a session: what this program says itself, over what a user's file says of security."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import zenoh

from pipeline.errors import HostError

LEASE_MS = 5000  # a transport that is silent for so long is closed; four times as often something is sent
RETRY_MS = 200  # between attempts to connect
# What a file may not say, as this program does, and the option that says it where there is one.
_RESERVED = {
    "mode": "",
    "listen": "--listen",
    "connect": "--connect",
    "scouting": "",
    "transport/link/tx/lease": "",
    "transport/shared_memory/enabled": "",
}
_TLS = "transport/link/tls"
_DICTIONARY, _USER = "transport/auth/usrpwd/dictionary_file", "transport/auth/usrpwd/user"
_FILES = (
    *(f"{_TLS}/{key}" for key in ("root_ca_certificate", "listen_private_key", "listen_certificate")),
    *(f"{_TLS}/{key}" for key in ("connect_private_key", "connect_certificate")),
    _DICTIONARY,
)


def configuration(listen: Sequence[str], connect: Sequence[str], file: Path | None = None) -> zenoh.Config:
    """Peers at explicit endpoints: no scouting, no gossip, no shared memory (killed processes would leave segments).

    file: a zenoh configuration (JSON5 or YAML) with what else there is to say: TLS, user and password, access control.
    Files that it names are relative to it. Raises HostError if it cannot be read, or names files that cannot, and
    where an endpoint is none.
    """
    config = _read(file) if file else zenoh.Config()
    settings = {
        "mode": "peer",
        "listen/endpoints": list(listen),
        "connect/endpoints": list(connect),
        "connect/timeout_ms": -1 if connect else 0,
        "connect/exit_on_failure": False,
        "connect/retry": {"period_init_ms": RETRY_MS, "period_max_ms": 5 * RETRY_MS, "period_increase_factor": 2},
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "transport/link/tx/lease": LEASE_MS,
        "transport/shared_memory/enabled": False,
    }
    for key, value in settings.items():
        try:
            config.insert_json5(key, json.dumps(value))
        except zenoh.ZError as error:
            raise HostError(f"{json.dumps(value)}: no endpoints; expected such as tcp/10.0.0.1:7447") from error
    return config


def _read(file: Path) -> zenoh.Config:
    try:
        config = zenoh.Config.from_file(str(file))
    except zenoh.ZError as error:
        raise HostError(f"{file}{_place_and_reason(str(error))}") from error
    default = zenoh.Config()
    for key, option in _RESERVED.items():
        if config.get_json(key) != default.get_json(key):
            remedy = f"use {option}" if option else "towline sets it itself"
            raise HostError(f"{file}: {key.replace('/', '.')} cannot be set here: {remedy}")
    for key in _FILES:
        named = json.loads(config.get_json(key))
        if named is not None:
            config.insert_json5(key, json.dumps(str(_readable(file, key, named))))
    if json.loads(config.get_json(_DICTIONARY)) and not json.loads(config.get_json(_USER)):
        text = "a dictionary of users, but no user and password by which this machine's own processes log in"
        raise HostError(f"{file}: transport.auth.usrpwd has {text}")
    return config


def _readable(file: Path, key: str, named: str) -> Path:
    """Where the file that is named is. Raises HostError if it cannot be read."""
    path = file.parent.absolute() / named
    try:
        path.open("rb").close()
    except OSError as error:
        raise HostError(f"{file}: {key.replace('/', '.')}: {path}: {error.strerror}") from error
    return path


def _place_and_reason(text: str) -> str:
    """The end of a message that begins with a file's name, from zenoh's words about it."""
    found = re.search(r'msg: "(?P<reason>.*)", location: Some\(Location \{ line: (\d+), column: (\d+)', text, re.DOTALL)
    if found:
        return f":{found[2]}:{found[3]} {found['reason']}"
    found = re.search(r"--> (\d+):(\d+)\n.*= (.*)", without_sources(text), re.DOTALL)
    if found:
        return f":{found[1]}:{found[2]} {found[3]}"
    return f": no zenoh configuration: {without_sources(text).splitlines()[0][:300]}"


def without_sources(text: str) -> str:
    """Zenoh's words without the places in its sources."""
    return re.sub(r"\s+at /\S+\.rs:\d+\.?", "", text).strip()


def open_session(config: zenoh.Config) -> zenoh.Session:
    """Raises HostError where an endpoint cannot be listened at or connected to."""
    try:
        return zenoh.open(config)
    except zenoh.ZError as error:
        raise HostError(f"zenoh cannot be started: {without_sources(str(error)).splitlines()[0][:300]}") from error


def close_session(session: zenoh.Session) -> None:
    """Close it, without which the process would not exit; raises nothing, also where it is closed.

    Zenoh waits up to 15 s for what is still to be sent to somebody who takes nothing, and complains; then that one
    finds out by its lease.
    """
    with suppress(zenoh.ZError):
        session.close()
