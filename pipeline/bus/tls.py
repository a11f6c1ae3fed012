"""Why a machine's TLS connection is refused, in words: zenoh itself tries again and says nothing."""

from __future__ import annotations

import json
import socket
import ssl
from collections.abc import Sequence
from pathlib import Path

from pipeline.bus.configuration import configuration

TIMEOUT_S = 1.0  # for each step of the handshake, and to wait for what the other side says of our certificate


def refusals(connect: Sequence[str], file: Path | None) -> list[str]:
    """A text for each TLS endpoint that does not let this machine in or is not to be trusted; others are passed over.

    Raises HostError as `configuration` does.
    """
    endpoints = [endpoint.removeprefix("tls/") for endpoint in connect if endpoint.startswith("tls/")]
    if not endpoints:
        return []
    tls: dict[str, str | bool | None] = json.loads(configuration([], connect, file).get_json("transport/link/tls"))
    return [text for endpoint in endpoints if (text := _refusal(endpoint, tls))]


def _refusal(endpoint: str, tls: dict[str, str | bool | None]) -> str:
    """What a handshake with HOST:PORT ends with; "" where it is fine, or nobody is there."""
    host, _, port = endpoint.partition("?")[0].rpartition(":")
    try:
        with (
            socket.create_connection((host.strip("[]"), int(port)), TIMEOUT_S) as plain,
            _context(tls).wrap_socket(plain, server_hostname=host.strip("[]")) as secured,
        ):
            secured.recv(1)  # what the other side has against our certificate comes after the handshake
    except ssl.SSLCertVerificationError as error:
        return f"tls/{endpoint} is not trusted: {error.verify_message}"
    except ssl.SSLError as error:
        return f"tls/{endpoint} refuses this machine: {(error.reason or str(error)).lower().replace('_', ' ')}"
    except OSError:
        return ""
    return ""


def _context(tls: dict[str, str | bool | None]) -> ssl.SSLContext:
    """As zenoh would connect."""
    context = ssl.create_default_context(cafile=_path(tls, "root_ca_certificate"))
    context.check_hostname = tls["verify_name_on_connect"] is not False
    certificate = _path(tls, "connect_certificate")
    if certificate and tls["enable_mtls"]:
        context.load_cert_chain(certificate, _path(tls, "connect_private_key"))
    return context


def _path(tls: dict[str, str | bool | None], key: str) -> str | None:
    return str(tls[key]) if tls[key] else None
