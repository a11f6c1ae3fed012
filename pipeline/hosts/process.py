"""A host at work: offers itself on the bus, runs the sections that a conductor gives it, and ends with the run."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path

from pipeline.bus.zenoh import HostBus
from pipeline.hosts.serving import Serving

POLL_S = 0.2  # how often a host that is not asked anything looks whether its conductor is there


def serve(
    name: str,
    connect: Sequence[str],
    process: str = "",
    config: Path | None = None,
    *,
    is_once: bool,
    tell: Callable[[str], None] = lambda _: None,
) -> None:
    """Offer a host and answer until its run ends, or for ever. Raises HostError where the bus cannot be opened."""
    bus = HostBus(name, connect, process, config)
    try:
        serving, led_s = Serving(name), time.monotonic()
        while not (serving.ended and is_once):
            if serving.ended:
                tell("the run has ended")
                serving.abandon()
            data = bus.receive(POLL_S)
            if data is not None:
                _answer(serving, bus, data, tell)
            if bus.is_led or not serving.run:
                led_s = time.monotonic()
            elif time.monotonic() - led_s > serving.limit_s:
                tell(f"the conductor has been away for {serving.limit_s:g} s: its run is given up")
                serving.abandon()
    finally:
        bus.close()


def _answer(serving: Serving, bus: HostBus, data: bytes, tell: Callable[[str], None]) -> None:
    run, reply = serving.run, serving.answer(data)
    if serving.run != run:
        bus.watch(serving.run)
        tell(f"runs {', '.join(serving.components)}")
    if reply is not None:
        bus.send(reply)
