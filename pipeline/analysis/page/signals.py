"""The recorded channels that a report draws, read from the log in one pass."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pipeline.analysis.known import first_of_each, known, oddities
from pipeline.analysis.scenario_entries import Entries, entries
from pipeline.log.reader import ChannelInfo, Log

# Bundles that take room and are drawn nowhere: the laws of power bonds, the components of a sea.
UNDRAWN = ("law", "accepted", "accelerance", "waves")
LARGEST = 600  # floats of a port that is drawn
_NONE = np.empty(0, np.int64)


class Signals:
    """Ports by channel and name; times in seconds, each once; numbers that are none are NaN. oddities: a line each.

    used: channel and port of all values that were asked for, which tabs do to draw them.
    """

    def __init__(self, log: Log):
        """Reads them. Raises LogError if the log is damaged."""
        self.channels = log.channels
        self.entries = entries(log) or Entries("", {})
        self.start, self.end = log.start_ns / 1e9, log.end_ns / 1e9
        self.events = [(t_ns / 1e9, text) for t_ns, text in log.events()]
        self.used: set[tuple[str, str]] = set()
        self._ports = {name: list(_drawn(info)) for name, info in log.channels.items() if info.count}
        counts = {name: log.channels[name].count for name, ports in self._ports.items() if ports}
        times, unknown = self._read(log, counts)
        self.oddities = [
            line
            for name, info in log.channels.items()
            if name in counts or not info.count
            for line in oddities(name, times.get(name, _NONE), unknown.get(name, 0), log.end_ns)
        ]
        first = {name: first_of_each(t_ns) for name, t_ns in times.items()}
        self._t = {name: t_ns[first[name]] / 1e9 for name, t_ns in times.items()}
        for name in (name for name in counts if not first[name].all()):
            self._values[name] = {port: values[first[name]] for port, values in self._values[name].items()}

    def _read(self, log: Log, counts: dict[str, int]) -> tuple[dict[str, np.ndarray], dict[str, int]]:
        """All messages: times [ns] by channel, and how many messages hold numbers that are not known."""
        times = {name: np.empty(count, np.int64) for name, count in counts.items()}
        self._values = {
            name: {port: np.empty((counts[name], part.stop - part.start)) for port, part in self._ports[name]}
            for name in counts
        }
        done, unknown = dict.fromkeys(counts, 0), dict.fromkeys(counts, 0)
        for name, t_ns, values in log.parts(list(counts)):
            rows = slice(done[name], done[name] + len(t_ns))
            times[name][rows] = t_ns
            kept = known(values)
            unknown[name] += 0 if kept is values else int(np.isnan(kept).any(axis=1).sum())
            for port, part in self._ports[name]:
                self._values[name][port][rows] = kept[:, part]
            done[name] = rows.stop
        return times, unknown

    def has(self, channel: str, *ports: str) -> bool:
        """Whether all these ports were recorded."""
        return all(port in self._values.get(channel, {}) for port in ports)

    def having(self, *ports: str) -> list[str]:
        """The channels that have all these ports."""
        return [name for name in self._values if self.has(name, *ports)]

    def t(self, channel: str) -> np.ndarray:
        """(k,) [s]."""
        return self._t[channel]

    def port(self, channel: str, port: str) -> np.ndarray:
        """(k, *shape)."""
        values = self.rows(channel, port)
        return values.reshape(len(values), *self.channels[channel].port(port)[0].shape)

    def rows(self, channel: str, port: str) -> np.ndarray:
        """(k, n): also of a port that is one number, as components of a user's own may have it under any name."""
        self.used.add((channel, port))
        return self._values[channel][port]

    def shape(self, channel: str, port: str) -> tuple[int, ...]:
        """Of each message."""
        return self.channels[channel].port(port)[0].shape

    def ports(self, channel: str) -> list[str]:
        """Names of the ports read."""
        return list(self._values.get(channel, {}))


def _drawn(info: ChannelInfo) -> Iterator[tuple[str, slice]]:
    for port in info.ports:
        if 0 < port.size <= LARGEST and not port.name.split(".")[0].split("_")[0].startswith(UNDRAWN):
            yield port.name, info.port(port.name)[1]
