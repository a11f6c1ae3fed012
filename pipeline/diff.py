"""Compares two logs channel by channel, chunk by chunk and image by image: they may be larger than memory."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from heapq import merge
from itertools import groupby
from operator import itemgetter

import numpy as np

from components.contract import ImagePort, Port
from pipeline.log.images import topic
from pipeline.log.reader import ChannelInfo, Log

Rows = tuple[np.ndarray, np.ndarray]  # times (k,) [ns] and values (k, n)
END_NS = np.iinfo(np.int64).max


@dataclass(frozen=True)
class ChannelDiff:
    """Messages in either log, and the largest absolute difference of any field at equal times.

    max_abs: None where there are no such times, or the ports differ. times_equal: every message has one of its time
    in the other log. port_differences: in name, unit, shape, frame or order, a sentence each; empty if there are none.
    """

    messages_a: int
    messages_b: int
    max_abs: float | None
    times_equal: bool
    port_differences: tuple[str, ...] = ()


@dataclass(frozen=True)
class Diff:
    """identical: every component and bond channel has the same ports and holds the same messages bit for bit.

    channels: by name; images by topic, their max_abs in grey levels.
    """

    identical: bool
    channels: dict[str, ChannelDiff]


def _shown(port: Port) -> str:
    return " ".join(filter(None, (f"{port.name} [{port.unit}]", str(port.shape) if port.shape else "", port.frame)))


def _port_differences(a: tuple[Port, ...], b: tuple[Port, ...]) -> tuple[str, ...]:
    """How two lists of ports differ; descriptions are but text."""
    in_a, in_b = ({port.name: _shown(port) for port in ports} for ports in (a, b))
    names = [*in_a, *(name for name in in_b if name not in in_a)]
    found = [
        f"{in_a.get(name, 'no ' + name)} in a, {in_b.get(name, 'no ' + name)} in b"
        for name in names
        if in_a.get(name) != in_b.get(name)
    ]
    if not found and list(in_a) != list(in_b):
        found.append(f"order {', '.join(in_a)} in a, {', '.join(in_b)} in b")
    return tuple(found)


def _largest(a: np.ndarray, b: np.ndarray) -> float:
    """Largest absolute difference of two arrays; NaN if a value is not finite in one of them only."""
    if a.tobytes() == b.tobytes():
        return 0.0
    with np.errstate(invalid="ignore"):
        difference = np.abs(a - b)
    same = (a == b) | (np.isnan(a) & np.isnan(b))
    return float(np.where(same, 0.0, difference).max(initial=0.0))


class _Unsettled:
    """Rows of one log's channel whose times the other log may not have reached yet."""

    def __init__(self, info: ChannelInfo):
        self._left = info.count
        self._times = np.empty(0, np.int64)
        self._values = np.empty((0, sum(port.size for port in info.ports)))

    def add(self, times: np.ndarray, values: np.ndarray) -> None:
        self._left -= len(times)
        self._times = np.concatenate([self._times, times])
        self._values = np.concatenate([self._values, values])

    def horizon_ns(self) -> int:
        """All rows before this time were added."""
        if self._left <= 0:
            return END_NS
        return int(self._times[-1]) if len(self._times) else -1

    def take(self, before_ns: int) -> Rows:
        """Rows before a time; they are forgotten here."""
        count = int(np.searchsorted(self._times, before_ns))
        taken = self._times[:count], self._values[:count]
        self._times, self._values = self._times[count:], self._values[count:]
        return taken


class _Comparison:
    """One channel of both logs."""

    def __init__(self, a: ChannelInfo, b: ChannelInfo):
        self._counts = a.count, b.count
        self._sides = _Unsettled(a), _Unsettled(b)
        self._port_differences = _port_differences(a.ports, b.ports)
        self._times_equal = a.count == b.count
        self._bits_equal = True
        self._max_abs: float | None = None

    def add(self, side: int, times: np.ndarray, values: np.ndarray) -> None:
        """Take in a part of log a (side 0) or b (1), and compare what both have reached."""
        self._sides[side].add(times, values)
        before_ns = min(unsettled.horizon_ns() for unsettled in self._sides)
        self._compare(*(unsettled.take(before_ns) for unsettled in self._sides))

    def _compare(self, a: Rows, b: Rows) -> None:
        (times_a, values_a), (times_b, values_b) = a, b
        if not np.array_equal(times_a, times_b):
            self._times_equal = False
            _, in_a, in_b = np.intersect1d(times_a, times_b, return_indices=True)
            values_a, values_b = values_a[in_a], values_b[in_b]
        if len(values_a) and not self._port_differences:
            self._bits_equal = self._bits_equal and values_a.tobytes() == values_b.tobytes()
            self._max_abs = float(np.maximum(self._max_abs or 0.0, _largest(values_a, values_b)))

    def result(self) -> tuple[bool, ChannelDiff]:
        """Whether the channel is the same bit for bit, and how it differs; after all parts were added."""
        same = self._times_equal and self._bits_equal and not self._port_differences
        return same, ChannelDiff(*self._counts, self._max_abs, self._times_equal, self._port_differences)


def _parts(side: int, log: Log, names: list[str]) -> Iterator[tuple[int, str, np.ndarray, np.ndarray]]:
    for name, times, values in log.parts(names):
        yield side, name, times, values


def _outputs(log: Log) -> dict[str, tuple[str, ImagePort]]:
    """Image outputs by topic: component and port."""
    return {topic(name, port.name): (name, port) for name, info in log.channels.items() for port in info.images}


def _image_diff(a: Log, b: Log, name: str, ports: tuple[ImagePort, ImagePort]) -> tuple[bool, ChannelDiff]:
    """Whether the pixels of an image output are the same, and how they differ."""
    sides = list(zip((a, b), ports, strict=True))
    count_a, count_b = (log.image_count(name, port.name) for log, port in sides)
    port_differences, times_equal, max_abs = _port_differences(ports[:1], ports[1:]), True, None
    messages = merge(*(log.image_messages(name, port.name) for log, port in sides), key=itemgetter(0))
    for t_ns, group in groupby(messages, key=itemgetter(0)):
        found = [data for _, data in group]
        times_equal = times_equal and len(found) == len(sides)
        if len(found) == len(sides) and not port_differences:
            max_abs = max_abs or 0.0
            if found[0] != found[1]:
                seen = [log.image(name, port, t_ns, data) for (log, port), data in zip(sides, found, strict=True)]
                max_abs = max(max_abs, float(np.abs(seen[0].astype(np.int16) - seen[1]).max()))
    same = times_equal and not max_abs and not port_differences
    return same, ChannelDiff(count_a, count_b, max_abs, times_equal, port_differences)


def _only_in(count: int, is_a: bool) -> ChannelDiff:
    text = f"only in {'a' if is_a else 'b'}"
    return ChannelDiff(count if is_a else 0, 0 if is_a else count, None, count == 0, (text,))


def diff_logs(a: Log, b: Log) -> Diff:
    """Compare all channels of either log. Raises LogError if one is damaged."""
    shared = [name for name in a.channels if name in b.channels]
    comparisons = {name: _Comparison(a.channels[name], b.channels[name]) for name in shared}
    both = (_parts(side, log, shared) for side, log in enumerate((a, b)))
    for side, name, times, values in merge(*both, key=lambda part: part[2].max(initial=-1)):
        comparisons[name].add(side, times, values)
    results = {name: comparison.result() for name, comparison in comparisons.items()}
    outputs = [_outputs(log) for log in (a, b)]
    for key in (key for key in outputs[0] if key in outputs[1]):
        (name, port), (_, other) = outputs[0][key], outputs[1][key]
        results[key] = _image_diff(a, b, name, (port, other))
    for log, there, is_a in ((a, outputs[0], True), (b, outputs[1], False)):
        counts = {name: info.count for name, info in log.channels.items()}
        counts |= {key: log.image_count(name, port.name) for key, (name, port) in there.items()}
        results |= {key: (False, _only_in(count, is_a)) for key, count in counts.items() if key not in results}
    identical = all(same for same, _ in results.values())
    return Diff(identical, {name: channel for name, (_, channel) in results.items()})


def within(diff: Diff, tolerance: float) -> bool:
    """Whether both logs hold the same channels, ports and times, and no value differs by more than the tolerance."""
    return all(
        c.times_equal and not c.port_differences and (c.max_abs is None or c.max_abs <= tolerance)
        for c in diff.channels.values()
    )
