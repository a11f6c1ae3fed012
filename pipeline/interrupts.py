"""Ctrl-C and SIGTERM: raised where they do no harm, and never lost."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_came: list[int] = []


def begin() -> None:
    """Have both raise KeyboardInterrupt from now on, SIGINT unless it is ignored, as in the background."""
    _came.clear()
    for number in _SIGNALS:
        if number == signal.SIGTERM or signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, _raise)


def _raise(number: int, _frame: object) -> None:
    _came.append(number)
    raise KeyboardInterrupt


def raise_if_lost() -> None:
    """Raise again what a callback from compiled code, as the compiler's own, could not pass on."""
    if _came:
        raise KeyboardInterrupt


@contextmanager
def held() -> Iterator[Callable[[], None]]:
    """Hold both back, so that they never fall into a write; yields what raises KeyboardInterrupt if one came.

    A second one is not held back: a component that never returns can be left.
    """
    came: list[int] = []

    def note(number: int, _frame: object) -> None:
        came.append(number)
        if len(came) > 1:
            raise KeyboardInterrupt

    def raise_if_interrupted() -> None:
        if came:
            raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():
        yield raise_if_interrupted
        return
    before = {number: signal.signal(number, note) for number in _SIGNALS}
    try:
        yield raise_if_interrupted
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
