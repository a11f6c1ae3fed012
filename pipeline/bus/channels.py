"""Channels on the bus for whoever subscribes: the bytes of the log, when they are of, and the schemas by query."""

from __future__ import annotations

import struct

import zenoh

CHANNELS, SCHEMAS = "towline/channel", "towline/schema"  # keys; a topic below, without the slash it may begin with
PROTOBUF = zenoh.Encoding.APPLICATION_PROTOBUF
_TIME = struct.Struct("<q")


def simulated_ns(attachment: bytes) -> int:
    """The time of a message, as it is attached to it."""
    return _TIME.unpack(attachment)[0]


def _key(above: str, topic: str) -> str:
    return f"{above}/{topic.lstrip('/')}"


class Channels:
    """Publishes channels in a session, by CongestionControl.BLOCK: a subscriber that keeps up misses nothing.

    One that takes nothing for five seconds is disconnected by zenoh, and holds the sender up for as long.
    """

    def __init__(self, session: zenoh.Session):
        self._session = session
        self._publishers: dict[str, zenoh.Publisher] = {}
        self._schemas: dict[str, tuple[str, bytes]] = {}
        self._queryable = session.declare_queryable(f"{SCHEMAS}/**", self._answer)

    def declare(self, topic: str, message: str, descriptors: bytes) -> None:
        """Make a channel known. message: its full protobuf name; descriptors: a FileDescriptorSet that has it."""
        self._schemas[_key(SCHEMAS, topic)] = message, descriptors
        self._publishers[topic] = self._session.declare_publisher(
            _key(CHANNELS, topic),
            encoding=PROTOBUF.with_schema(message),
            congestion_control=zenoh.CongestionControl.BLOCK,
            express=True,
        )

    def is_wanted(self, topic: str) -> bool:
        """Whether anybody subscribes to a channel."""
        return self._publishers[topic].matching_status.matching  # type: ignore - the stub says bool

    def put(self, topic: str, t_ns: int, payload: bytes) -> None:
        """Publish a message of simulated time t_ns."""
        self._publishers[topic].put(payload, attachment=_TIME.pack(t_ns))

    def _answer(self, query: zenoh.Query) -> None:
        with query:
            for key, (message, descriptors) in self._schemas.items():
                if query.key_expr.intersects(zenoh.KeyExpr(key)):
                    encoding = PROTOBUF.with_schema("google.protobuf.FileDescriptorSet")
                    query.reply(key, descriptors, encoding=encoding, attachment=message)
