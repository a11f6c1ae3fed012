"""Who may take part in a run, and that nobody else changes it. Authority: the local run's digest."""

from __future__ import annotations

import datetime
import ipaddress
import json
import random
import re
import socket
import struct
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import zenoh
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec

from pipeline.bus.configuration import close_session, configuration, open_session
from pipeline.bus.identity import SEAL_BYTES, Identity
from pipeline.bus.messages import DONE, STATE, STEP, Message, MessageError, pack, unpack
from pipeline.bus.tls import refusals
from pipeline.errors import HostError
from pipeline.hosts.deployment import BusOptions
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

ROOT = Path(__file__).parents[2]
TEXT = """
duration: {seconds} s
step: 10 ms
hosts: {{b: crane}}
machines: {{crane: {{limit: {limit}}}}}
components:
  a: {{model: motion.van_der_pol, inputs: {{neighbour: {{from: b.position, delay: true}}}}}}
  b: {{model: motion.van_der_pol, inputs: {{neighbour: a.position}}}}
"""
LIMIT_S = 60.0


def run(path, options: BusOptions | None, said: list[str] | None = None, seconds: float = 1, limit: str = "30 s"):
    scenario = load_scenario_text(TEXT.format(seconds=seconds, limit=limit), "secure.yaml", ROOT / "scenarios")
    tell = said.append if said is not None else lambda _: None
    return run_scenario(scenario, build_graph(scenario), path, Options(bus=options, tell=tell), lambda _: None)


def free(protocol: str) -> str:
    """An endpoint of the loopback."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"{protocol}/127.0.0.1:{probe.getsockname()[1]}"


@contextmanager
def machine(endpoint: str, config: Path | None = None) -> Iterator[subprocess.Popen]:
    """`towline host --name crane`."""
    words = ["host", "--connect", endpoint, "--name", "crane", *(["--bus-config", str(config)] if config else [])]
    child = subprocess.Popen(
        [sys.executable, "-m", "pipeline.cli", *words],
        cwd=ROOT,
        stderr=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        yield child
    finally:
        child.kill()
        child.communicate(timeout=LIMIT_S)


class Authority:
    """A certificate authority in a folder."""

    def __init__(self, folder: Path):
        self._folder = folder
        folder.mkdir()
        self._key = ec.generate_private_key(ec.SECP256R1())
        self._name = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, f"authority {folder.name}")])
        own = self._signed(self._name, self._key, x509.BasicConstraints(ca=True, path_length=None))
        self._write("ca.pem", own.public_bytes(serialization.Encoding.PEM))

    def issue(self, name: str) -> None:
        """A certificate NAME.pem with NAME.key, for servers at and clients from 127.0.0.1."""
        key = ec.generate_private_key(ec.SECP256R1())
        address = x509.SubjectAlternativeName([x509.IPAddress(ipaddress.ip_address("127.0.0.1"))])
        subject = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, name)])
        self._write(f"{name}.pem", self._signed(subject, key, address).public_bytes(serialization.Encoding.PEM))
        form = serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
        self._write(f"{name}.key", key.private_bytes(*form))

    def _signed(self, subject: x509.Name, key: ec.EllipticCurvePrivateKey, extension) -> x509.Certificate:
        now = datetime.datetime.now(datetime.UTC)
        made = x509.CertificateBuilder().subject_name(subject).issuer_name(self._name).public_key(key.public_key())
        made = made.serial_number(x509.random_serial_number()).add_extension(extension, critical=True)
        made = made.not_valid_before(now - datetime.timedelta(days=1)).not_valid_after(now + datetime.timedelta(days=1))
        return made.sign(self._key, hashes.SHA256())

    def _write(self, name: str, data: bytes) -> None:
        (self._folder / name).write_bytes(data)


def tls_file(path: Path, ca: str, name: str, **more) -> Path:
    """A zenoh configuration for mutual TLS; names are relative to it."""
    files = {f"{side}_{what}": f"{name}.{end}" for side in ("listen", "connect") for what, end in ENDS.items()}
    tls = {"root_ca_certificate": ca, "enable_mtls": True, **files}
    path.write_text(json.dumps({"transport": {"link": {"tls": tls}, **more}}))
    return path


ENDS = {"certificate": "pem", "private_key": "key"}


@pytest.fixture(scope="module")
def tls(tmp_path_factory) -> dict[str, Path]:
    """Configurations: of the conductor, of a machine, of one with another authority's certificate, of one without."""
    folder = tmp_path_factory.mktemp("tls")
    ours, others = Authority(folder / "ours"), Authority(folder / "others")
    ours.issue("conductor")
    ours.issue("crane")
    others.issue("crane")
    good = tls_file(folder / "ours" / "crane.json", "ca.pem", "crane")
    strange = tls_file(folder / "others" / "crane.json", "../ours/ca.pem", "crane")
    distrusting = tls_file(folder / "others" / "distrusting.json", "ca.pem", "crane")
    bare = folder / "ours" / "bare.json"
    bare.write_text(json.dumps({"transport": {"link": {"tls": {"root_ca_certificate": "ca.pem"}}}}))
    conductor = tls_file(folder / "ours" / "conductor.json", "ca.pem", "conductor")
    return {"conductor": conductor, "good": good, "strange": strange, "distrusting": distrusting, "bare": bare}


def test_mutual_tls(tls, tmp_path):
    endpoint = free("tls")
    with machine(endpoint, tls["good"]):
        result = run(tmp_path / "tls.mcap", BusOptions((endpoint,), tls["conductor"]))
    assert result.digest == run(tmp_path / "local.mcap", None).digest


def test_wrong_certificate(tls, tmp_path):
    """It does not get in, and both sides are told."""
    endpoint = free("tls")
    with machine(endpoint, tls["strange"]) as crane:
        with pytest.raises(HostError, match=r"host crane \(b\) was waited for"):
            run(tmp_path / "a.mcap", BusOptions((endpoint,), tls["conductor"]), limit="5 s")
        crane.terminate()
        _, err = crane.communicate(timeout=LIMIT_S)
    assert f"towline: host crane: {endpoint} refuses this machine: " in err


@pytest.mark.parametrize(
    ("who", "said"),
    [
        ("good", None),
        ("strange", "refuses this machine: .*"),
        ("bare", "refuses this machine: .*certificate required"),
        ("distrusting", "is not trusted: .*"),
    ],
)
def test_why_a_machine_is_refused(who, said, tls):
    endpoint = free("tls")
    session = open_session(configuration([endpoint], [], tls["conductor"]))
    try:
        found = refusals([endpoint, "tcp/127.0.0.1:1"], tls[who])
    finally:
        session.close()
    assert not found if said is None else re.fullmatch(f"{endpoint} {said}", found[0])
    assert refusals([endpoint], tls[who]) == []  # nobody is there


def test_certificate_that_is_none(tls, tmp_path):
    file = tls_file(tls["conductor"].parent / "none.json", "ca.pem", "none")
    for end in ENDS.values():
        (file.parent / f"none.{end}").write_text("none\n")
    with pytest.raises(HostError, match=r"zenoh cannot be started: .*TLS") as error:
        run(tmp_path / "a.mcap", BusOptions((free("tls"),), file))
    assert "\n" not in str(error.value)


@pytest.fixture
def users(tmp_path) -> dict[str, Path]:
    """Configurations with user and password: of the conductor, of a machine, of one with a wrong password."""
    (tmp_path / "users.txt").write_text("conductor:deep\ncrane:blue\n")
    found = {}
    for name, login in {
        "conductor": {"user": "conductor", "password": "deep", "dictionary_file": "users.txt"},
        "good": {"user": "crane", "password": "blue"},
        "wrong": {"user": "crane", "password": "grey"},
    }.items():
        found[name] = tmp_path / f"{name}.json"
        found[name].write_text(json.dumps({"transport": {"auth": {"usrpwd": login}}}))
    return found


def test_password(users, tmp_path):
    endpoint = free("tcp")
    with machine(endpoint, users["good"]):
        result = run(tmp_path / "a.mcap", BusOptions((endpoint,), users["conductor"]))
    assert result.digest == run(tmp_path / "local.mcap", None).digest


def test_wrong_password(users, tmp_path):
    endpoint = free("tcp")
    with machine(endpoint, users["wrong"]), pytest.raises(HostError, match=r"host crane \(b\) was waited for"):
        run(tmp_path / "a.mcap", BusOptions((endpoint,), users["conductor"]), limit="3 s")


class Stranger:
    """Connects where machines do, listens to everything, and sends in the name of conductor and hosts.

    Whatever passes, it sends again, mangled, cut, with other numbers, sealed as another, as the message to come, and
    as the reply to a request. It is a client, whose messages zenoh passes on to hosts, which it does not for peers.
    """

    def __init__(self, endpoint: str):
        self.sent, self._is_over = Counter[str](), False
        self._dice, self._identity = random.Random(3), Identity()
        config = configuration([], [endpoint])
        config.insert_json5("mode", '"client"')
        self._session = zenoh.open(config)
        self._subscribers = [
            self._session.declare_subscriber(f"towline/{way}/**", self._forge) for way in ("in", "out")
        ]

    def _forge(self, sample: zenoh.Sample) -> None:
        key, data = str(sample.key_expr), sample.payload.to_bytes()
        if self._is_over:
            return
        for kind, to, forged in self._forgeries(key, data):
            # Not to itself: its own callback would have to take it, and waits here where too many are there already.
            self._session.put(to, forged, allowed_destination=zenoh.Locality.REMOTE)
            self.sent[kind] += 1

    def _forgeries(self, key: str, data: bytes) -> Iterator[tuple[str, str, bytes]]:
        """What, to which key, bytes."""
        yield "again", key, data
        yield "garbage", key, self._dice.randbytes(self._dice.randrange(200))
        yield "cut", key, data[: self._dice.randrange(len(data))]
        try:
            message = unpack(data[:-SEAL_BYTES])
        except MessageError:
            return
        if message.kind not in (STEP, DONE):
            return
        others = message._replace(numbers=struct.pack(f"<{len(message.values)}d", *(1.0 + message.values)))
        yield from self._sealed_anyhow("numbers", key, others, data)
        yield from self._sealed_anyhow("to come", key, others._replace(sequence=message.sequence + 1), data)
        if message.kind == STEP:
            host, process = key.split("/")[2:4]
            reply = message._replace(kind=DONE, flags=STATE, numbers=struct.pack("<4d", 1.0, 2.0, 3.0, 4.0))
            yield from self._sealed_anyhow("reply", f"towline/out/{host}/{process}", reply, data)

    def _sealed_anyhow(self, kind: str, key: str, message: Message, data: bytes) -> Iterator[tuple[str, str, bytes]]:
        """Without a seal, with that of another message, with one of the stranger's own."""
        made = pack(message)
        own = self._identity.seal_with(key.split("/")[3]).sealed(made)
        yield from ((kind, key, forged) for forged in (made, made + data[-SEAL_BYTES:], own))

    def close(self) -> Counter[str]:
        """What it has sent; what it has not heard yet it lets pass."""
        self._is_over = True
        close_session(self._session)
        return self.sent


def test_stranger(tmp_path):
    """Ignored with a warning and counted, on both sides; the digest is the local run's."""
    endpoint, said, strangers = free("tcp"), [], []
    with machine(endpoint):
        scenario = load_scenario_text(TEXT.format(seconds=3, limit="30 s"), "secure.yaml", ROOT / "scenarios")

        def join(_: float) -> None:
            if not strangers:
                strangers.append(Stranger(endpoint))

        options = Options(bus=BusOptions((endpoint,)), tell=said.append)
        try:
            result = run_scenario(scenario, build_graph(scenario), tmp_path / "a.mcap", options, join)
        finally:  # an open session keeps the process from ending
            sent = sum((stranger.close() for stranger in strangers), Counter())
    local = run_scenario(scenario, build_graph(scenario), tmp_path / "local.mcap", Options(), lambda _: None)
    assert result.digest == local.digest
    assert min(sent[kind] for kind in ("again", "garbage", "cut", "numbers", "to come", "reply")) > 50
    for host in ("a", "crane"):
        assert result.hosts[host]["refused"] > 50
        assert any(f"host {host}" in line and "ignored and counted" in line for line in said)
        assert result.hosts[host]["restarts"] == 0
