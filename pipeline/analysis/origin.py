"""Where a channel of markers comes from, by the scenario in the log: the line behind it, its length, its ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypedDict

import numpy as np
import yaml

from pipeline.errors import LogError
from pipeline.log.reader import Log

SCENARIO = "scenario.yaml"  # the attachment with the resolved scenario


class _Entry(TypedDict, total=False):
    """What is read here of a component in a resolved scenario: texts with SI units, and counts."""

    parameters: dict[str, str | int]
    inputs: dict[str, str]


@dataclass(frozen=True)
class Origin:
    """scenario: its name. line: the channel with the line's nodes; "" where the log does not tell.

    length: of the line, unstretched [m]. arc: (m,) the markers' places along it from its end a [m].
    motion: channel and bundle of what moves end b, such as ("hand", "motion"). noise: of a marker, each axis [m].
    """

    scenario: str = ""
    line: str = ""
    length: float | None = None
    arc: np.ndarray | None = None
    motion: tuple[str, str] | None = None
    noise: float | None = None


def origin(log: Log, channel: str) -> Origin:
    """What the log's scenario says of the channel; as little as nothing where it holds none."""
    try:
        document = yaml.load(log.attachment(SCENARIO), Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
        name, entries = str(document["name"]), document["components"]
    except (LogError, yaml.YAMLError, KeyError, TypeError):
        return Origin()
    line = channel if "nodes" not in _inputs(entries, channel) else _source(entries, channel, "nodes")[0]
    end = _source(entries, line, "end_b")
    return Origin(
        scenario=name,
        line=line,
        length=_metres(entries, line, "length"),
        arc=_arc(entries, channel),
        motion=end if end[0] else None,
        noise=_metres(entries, channel, "noise") or None,
    )


def lines_without_markers(log: Log, tracked: list[str]) -> list[str]:
    """Channels with a line's nodes whose markers nothing tracks; tracked: the lines behind the channels judged."""
    if "" in tracked:
        return []  # the log does not tell which line a channel is of
    lines = [name for name, info in log.channels.items() if any(one.name == "nodes" for one in info.ports)]
    return [name for name in lines if name not in tracked]


def _inputs(entries: dict[str, _Entry], name: str) -> dict[str, str]:
    return entries.get(name, {}).get("inputs", {})


def _source(entries: dict[str, _Entry], name: str, port: str) -> tuple[str, str]:
    """Component and port that a plain wire comes from; ("", "") for any other wire or none."""
    wire = _inputs(entries, name).get(port)
    component, _, source = wire.partition(".") if isinstance(wire, str) else ("", "", "")
    return (component, source) if component in entries else ("", "")


def _metres(entries: dict[str, _Entry], name: str, parameter: str) -> float | None:
    """A length of a component: resolved scenarios write `3.5 m`. FMUs of Towline have parameters in a bundle."""
    given = entries.get(name, {}).get("parameters", {})
    number, _, unit = str(given.get(parameter, given.get(f"parameters.{parameter}", ""))).partition(" ")
    return float(number) if unit == "m" else None


def _arc(entries: dict[str, _Entry], channel: str) -> np.ndarray | None:
    """Places of equally spaced markers, the last one `offset` from end b: the parameters of markers.tracker."""
    length, spacing, offset = (_metres(entries, channel, name) for name in ("length", "spacing", "offset"))
    count = entries.get(channel, {}).get("parameters", {}).get("markers")
    if length is None or spacing is None or offset is None or not isinstance(count, int):
        return None
    return length - offset - spacing * np.arange(count - 1, -1, -1)
