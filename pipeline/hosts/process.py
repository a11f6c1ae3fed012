"""A host at work: offers itself on the bus, runs the sections that a conductor gives it, and ends with the run."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path

from pipeline.bus.identity import Identity
from pipeline.bus.tls import refusals
from pipeline.bus.zenoh import HostBus
from pipeline.hosts import facts
from pipeline.hosts.serving import Serving

ASK_S = 2.0  # between questions why nobody has work for this host
POLL_S = 0.2  # how often a host that is not asked anything looks whether its conductor is there


def serve(
    name: str,
    connect: Sequence[str],
    secret: str = "",
    config: Path | None = None,
    *,
    is_sealed: bool = True,
    is_once: bool,
    tell: Callable[[str], None] = lambda _: None,
) -> None:
    """Offer a host and answer until its run ends, or for ever. Raises HostError where the bus cannot be opened.

    secret: of its identity on the bus, a new one unless given.
    """
    facts.own()  # of what is imported by now
    bus = HostBus(name, connect, Identity(secret), config, look_s=POLL_S, is_sealed=is_sealed)
    serving = Serving(name)
    try:
        led_s, asked_s, told = time.monotonic(), time.monotonic(), set()
        while not (serving.ended and is_once):
            if serving.ended:
                tell("the run has ended")
                serving.abandon()
                bus.leave()
            data = bus.receive()
            if data is not None:
                _answer(serving, bus, data, tell)
            elif not serving.run and time.monotonic() - asked_s > ASK_S:
                told = _tell_news(refusals(connect, config), told, tell)
                asked_s = time.monotonic()
            if bus.is_led or not serving.run:
                led_s = time.monotonic()
            elif time.monotonic() - led_s > serving.limit_s:
                tell(f"the conductor has been away for {serving.limit_s:g} s: its run is given up")
                serving.abandon()
                bus.leave()
    finally:
        serving.abandon()
        bus.close()


def _tell_news(texts: Sequence[str], told: set[str], tell: Callable[[str], None]) -> set[str]:
    """Tell what is new; returns what was told last."""
    for text in set(texts) - told:
        tell(text)
    return set(texts)


def _answer(serving: Serving, bus: HostBus, data: bytes, tell: Callable[[str], None]) -> None:
    run, reply = serving.run, serving.answer(data)
    if serving.run != run:
        bus.follow(serving.run)
        tell(f"runs {', '.join(serving.components)}")
    if reply is not None:
        bus.send(reply)
