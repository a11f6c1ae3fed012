"""The page as one HTML text: tabs, charts as data, scripts and style inlined; it needs no other file and no network."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from html import escape
from importlib.resources import files
from typing import Any

from pipeline.analysis.page.charts import Chart, Window
from pipeline.analysis.page.scene import Scene
from pipeline.analysis.page.tab import Tab

SCRIPTS = ("decode.js", "player.js", "chart.js", "camera.js", "scene.js", "map.js", "tabs.js")
STYLE = "style.css"


def document(
    title: str,
    subtitle: str,
    tabs: Sequence[Tab],
    scene: Scene | None,
    times: Window,
    window: Window | None,
    events: Sequence[tuple[float, str]] = (),
) -> str:
    """times: of the record [s]; window: what charts show at first; events: times [s] and texts."""
    charts: list[Chart] = []
    body = "\n".join(line for tab in tabs for line in _tab(tab, charts))
    data: dict[str, Any] = {
        "t": [times.start, times.end],
        "window": None if window is None else [window.start, window.end],
        "events": [[t, text] for t, text in events],
        "charts": [chart.as_json() for chart in charts],
        "scene": scene,
    }
    buttons = "".join(
        f'<button role="tab" id="tab-{tab.name}" aria-controls="panel-{tab.name}">{escape(tab.title)}</button>'
        for tab in tabs
    )
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>\n{_asset(STYLE)}</style>\n</head>\n<body>\n"
        f'<header>\n<h1>{escape(title)}</h1>\n<p class="small">{escape(subtitle)}</p>\n'
        f'<nav role="tablist">{buttons}</nav>\n</header>\n'
        f'<noscript><p class="warning">Figures need JavaScript; the tables stand without it.</p></noscript>\n'
        f"<main>\n{body}\n</main>\n{PLAYER}\n"
        f'<script type="application/json" id="data">{_json(data)}</script>\n'
        f"<script>\n{''.join(_asset(name) for name in SCRIPTS)}</script>\n</body>\n</html>\n"
    )


PLAYER = (
    '<footer class="player"><button id="play" aria-label="play">▶</button>'
    '<input id="time" type="range" aria-label="time [s]"><output id="now"></output>'
    '<button id="faster" aria-label="speed of playing"></button>'
    '<button id="whole" hidden>whole record</button></footer>'
)


def _tab(tab: Tab, charts: list[Chart]) -> Iterator[str]:
    """The tab's HTML; charts in a row stand in one grid, and are added to the list."""
    yield f'<section id="panel-{tab.name}" role="tabpanel" aria-labelledby="tab-{tab.name}">'
    inside = False
    for item in tab.items:
        if isinstance(item, Chart) != inside:
            inside = not inside
            yield '<div class="figures">' if inside else "</div>"
        if isinstance(item, str):
            yield item
            continue
        lanes = f" <span>{escape(item.axis)}</span>" if item.lanes else ""
        caption = f'<p class="small">{escape(item.caption)}</p>' if item.caption else ""
        yield (
            f'<figure class="chart" id="chart-{len(charts)}">'
            f"<figcaption><b>{escape(item.title)}</b>{lanes}</figcaption>"
            f'<div class="legend"></div><div class="plot"></div>{caption}</figure>'
        )
        charts.append(item)
    if inside:
        yield "</div>"
    yield "</section>"


def _json(data: dict[str, Any]) -> str:
    """JSON that may stand in a script element: no `<`, no numbers that are none."""
    return json.dumps(data, allow_nan=False, separators=(",", ":"), ensure_ascii=False).replace("<", "\\u003c")


def _asset(name: str) -> str:
    return files("pipeline.analysis.page").joinpath(name).read_text(encoding="utf-8")
