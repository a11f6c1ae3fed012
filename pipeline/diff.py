"""Compares two logs channel by channel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.log.reader import Log

Rows = tuple[np.ndarray, np.ndarray]  # times (k,) [ns] and values (k, n)
NOTHING: Rows = np.empty(0, np.int64), np.empty((0, 0))


@dataclass(frozen=True)
class ChannelDiff:
    """Messages in either log, and the largest absolute difference of any field at equal times (None: no such times)."""

    messages_a: int
    messages_b: int
    max_abs: float | None


@dataclass(frozen=True)
class Diff:
    """identical: every component and bond channel holds the same messages bit for bit."""

    identical: bool
    channels: dict[str, ChannelDiff]


def _same(a: np.ndarray, b: np.ndarray) -> bool:
    return a.shape == b.shape and a.tobytes() == b.tobytes()


def _channel(a: Rows, b: Rows) -> tuple[bool, ChannelDiff]:
    (times_a, values_a), (times_b, values_b) = a, b
    identical = _same(times_a, times_b) and _same(values_a, values_b)
    _, in_a, in_b = np.intersect1d(times_a, times_b, return_indices=True)
    max_abs = None
    if len(in_a) and values_a.shape[1] == values_b.shape[1]:
        with np.errstate(invalid="ignore"):
            difference = np.abs(values_a[in_a] - values_b[in_b])
        max_abs = float(difference.max(initial=0.0))
    return identical, ChannelDiff(len(times_a), len(times_b), max_abs)


def diff_logs(a: Log, b: Log) -> Diff:
    """Compare all channels of either log."""
    read_a, read_b = a.read(), b.read()
    names = [*read_a, *(name for name in read_b if name not in read_a)]
    results = {name: _channel(read_a.get(name, NOTHING), read_b.get(name, NOTHING)) for name in names}
    identical = all(same for same, _ in results.values())
    return Diff(identical, {name: channel for name, (_, channel) in results.items()})


def within(diff: Diff, tolerance: float) -> bool:
    """Whether both logs hold the same channels and times, and no value differs by more than the tolerance."""
    return all(
        c.messages_a == c.messages_b and (c.messages_a == 0 or (c.max_abs is not None and c.max_abs <= tolerance))
        for c in diff.channels.values()
    )
