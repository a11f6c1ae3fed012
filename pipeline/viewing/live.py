"""A run's channels on a WebSocket, as Foxglove and Lichtblick connect to it: the log's bytes, as they are recorded."""

from __future__ import annotations

import socket
from typing import Any

from pipeline.errors import TowlineError

BACKLOG = 8192  # messages kept for a viewer that is slow; the oldest are dropped, and are in the log all the same
ABSENT = 'the WebSocket for viewers is not installed; pip install -e ".[live]" in the folder of Towline'


class Live:
    """A recorder's audience that serves every channel.

    It holds its port from the beginning and serves from the first look for viewers on, when all channels are declared:
    of one that is declared while a viewer is connected, the SDK may refuse the subscription ("Unknown channel ID").
    """

    def __init__(self, endpoint: str, name: str):
        """endpoint: HOST:PORT. name: shown by the viewers. Raises TowlineError."""
        host, port = _host_and_port(endpoint)
        self._foxglove = _module()
        self._context = self._foxglove.Context()
        self._channels: dict[str, Any] = {}
        self._server: Any = None
        self._endpoint, self._name, self._host = endpoint, name, host
        try:
            self._held = _held(host, port)
        except OSError as error:
            raise TowlineError(f"--live {endpoint}: cannot listen there: {error.strerror or error}") from error
        self._port = int(self._held.getsockname()[1])
        self.url = f"ws://{f'[{host}]' if ':' in host else host}:{self._port}"

    def declare(self, topic: str, message: str, descriptors: bytes) -> None:
        """Make a channel known. message: its full protobuf name; descriptors: a FileDescriptorSet that has it."""
        schema = self._foxglove.Schema(name=message, encoding="protobuf", data=descriptors)
        self._channels[topic] = self._foxglove.Channel(
            topic, schema=schema, message_encoding="protobuf", context=self._context
        )

    def is_wanted(self, topic: str) -> bool:
        """Whether any viewer shows the channel. Raises TowlineError if it cannot serve."""
        if self._server is None:
            self._serve()
        return self._channels[topic].has_sinks()

    def put(self, topic: str, t_ns: int, payload: bytes) -> None:
        """Send a message of simulated time t_ns."""
        self._channels[topic].log(payload, log_time=t_ns)

    def close(self) -> None:
        """Take leave of the viewers."""
        self._held.close()
        if self._server is not None:
            self._server.stop()

    def _serve(self) -> None:
        self._held.close()
        try:
            self._server = self._foxglove.start_server(
                name=self._name,
                host=self._host,
                port=self._port,
                message_backlog_size=BACKLOG,
                context=self._context,
            )
        except Exception as error:  # the server's are of many kinds
            raise TowlineError(f"--live {self._endpoint}: cannot listen there: {error}") from error


def _held(host: str, port: int) -> socket.socket:
    """A port, taken and not yet listening. Raises OSError."""
    family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
    one = socket.socket(family, kind, protocol)
    try:
        one.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        one.bind(address)
    except OSError:
        one.close()
        raise
    return one


def _module() -> Any:
    try:
        import foxglove
    except ImportError as error:
        raise TowlineError(ABSENT) from error
    return foxglove


def _host_and_port(endpoint: str) -> tuple[str, int]:
    host, _, port = endpoint.rpartition(":")
    if not host or not port.isdecimal() or int(port) > 65535:
        raise TowlineError(f"--live {endpoint}: expected HOST:PORT, such as 127.0.0.1:8765")
    return host.strip("[]"), int(port)
