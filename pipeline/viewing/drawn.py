"""What of a log's channels a viewer can draw: lines, bodies and curves, thinned to what a screen shows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from components.contract import Port
from pipeline.analysis.known import known
from pipeline.analysis.markers import is_estimate
from pipeline.log.reader import ChannelInfo, Log

PERIOD_NS = 100_000_000  # of what is drawn: a viewer takes them all into memory
CURVES = 6  # of one port in one plot: those of larger ports are spread over it
# What tells of the solver, not of the scene: it is in the log, and not on the screen.
ASIDE = ("validity.", "law_", "accepted_", "accelerance", "residual", "iterations", "sub_steps", "converged")

NO_POINTS = ("reference", "estimate", "wave", "low")  # bundles that are no points of their own


@dataclass(frozen=True)
class Drawn:
    """A channel's rows as a viewer takes them: times (k,) [ns], rows (k, n)."""

    channel: ChannelInfo
    t_ns: np.ndarray
    rows: np.ndarray

    def lines(self) -> Iterator[tuple[Port, np.ndarray]]:
        """Ports that are points along a line, (k, m, 3): east, north, up [m]."""
        for port, values in self._ports():
            if len(port.shape) == 2 and port.shape[0] > 1 and _is_place(port):
                yield port, _east_north_up(values.reshape(-1, *port.shape))

    def bodies(self) -> Iterator[tuple[Port, np.ndarray]]:
        """The position of a body, or of each point that moves by itself, (k, 3): east, north, up [m]."""
        names = {port.name for port in self.channel.ports}
        for port, values in self._ports():
            bundle = port.name.removesuffix("position")
            is_point = f"{bundle}velocity" in names and "position" not in names and not is_estimate(self.channel)
            is_drawn = port.name == "position" or (is_point and not bundle.startswith(NO_POINTS))
            if is_drawn and port.shape == (3,) and _is_place(port):
                yield port, _east_north_up(values)

    def curves(self) -> Iterator[tuple[Port, list[str], np.ndarray]]:
        """Ports to be plotted, with the names of their curves: (k, m), angles in degrees."""
        for port, values in self._ports():
            if port.name.startswith(ASIDE) or (len(port.shape) == 2 and _is_place(port)):
                continue
            at = np.unique(np.linspace(0, port.size - 1, min(port.size, CURVES)).round().astype(int))
            yield (
                port,
                [_curve(port, i) for i in at],
                np.degrees(values[:, at]) if port.unit == "rad" else values[:, at],
            )

    def _ports(self) -> Iterator[tuple[Port, np.ndarray]]:
        for port in self.channel.ports:
            yield port, self.rows[:, self.channel.port(port.name)[1]]


def _curve(port: Port, i: int) -> str:
    if port.shape == (3,) and port.frame == "NED" and port.unit != "rad":
        return ("north", "east", "down")[i]
    return port.name if port.size == 1 else f"{port.name}[{i}]"


def shown_unit(port: Port) -> str:
    """The unit of a port's curves."""
    return {"rad": "°", "1": ""}.get(port.unit, port.unit)


def drawn(log: Log) -> Iterator[Drawn]:
    """Each component's rows, one at most in PERIOD_NS; NaN for what no viewer can draw."""
    for name, (t_ns, rows) in log.read().items():
        if not len(t_ns):
            continue
        slots = t_ns // PERIOD_NS
        keep = np.concatenate([[True], np.diff(slots) > 0])
        yield Drawn(log.channel(name), t_ns[keep], known(rows[keep]))


def _is_place(port: Port) -> bool:
    return port.unit == "m" and port.frame == "NED" and port.shape[-1] == 3


def _east_north_up(places: np.ndarray) -> np.ndarray:
    return places[..., [1, 0, 2]] * np.array([1.0, 1.0, -1.0])
