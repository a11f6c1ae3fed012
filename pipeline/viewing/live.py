"""A run's channels on a WebSocket, as Foxglove and Lichtblick connect to it: the log's bytes, as they are recorded."""

from __future__ import annotations

from typing import Any

from pipeline.errors import TowlineError

BACKLOG = 8192  # messages kept for a viewer that is slow; the oldest are dropped, and are in the log all the same
ABSENT = 'the WebSocket for viewers is not installed; pip install -e ".[live]" in the folder of Towline'


class Live:
    """A recorder's audience that serves every channel."""

    def __init__(self, endpoint: str, name: str):
        """endpoint: HOST:PORT. name: shown by the viewers. Raises TowlineError."""
        host, port = _host_and_port(endpoint)
        self._foxglove = _module()
        self._context = self._foxglove.Context()
        self._channels: dict[str, Any] = {}
        try:
            self._server = self._foxglove.start_server(
                name=name, host=host, port=port, message_backlog_size=BACKLOG, context=self._context
            )
        except Exception as error:  # the server's are of many kinds
            raise TowlineError(f"--live {endpoint}: cannot listen there: {error}") from error
        self.url = f"ws://{f'[{host}]' if ':' in host else host}:{self._server.port}"

    def declare(self, topic: str, message: str, descriptors: bytes) -> None:
        """Make a channel known. message: its full protobuf name; descriptors: a FileDescriptorSet that has it."""
        schema = self._foxglove.Schema(name=message, encoding="protobuf", data=descriptors)
        self._channels[topic] = self._foxglove.Channel(
            topic, schema=schema, message_encoding="protobuf", context=self._context
        )

    def is_wanted(self, topic: str) -> bool:
        """Whether any viewer shows the channel."""
        return self._channels[topic].has_sinks()

    def put(self, topic: str, t_ns: int, payload: bytes) -> None:
        """Send a message of simulated time t_ns."""
        self._channels[topic].log(payload, log_time=t_ns)

    def close(self) -> None:
        """Take leave of the viewers."""
        self._server.stop()


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
