"""A report as one HTML page that needs no other file and no network, on a wide screen and on a phone."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from html import escape

from pipeline.analysis.report import Picture, Section
from pipeline.analysis.tables import INDICATORS, failures, noise, rows
from pipeline.analysis.validity import Cable

STYLE = """
:root { color-scheme: light; }
body { font: 16px/1.45 system-ui, sans-serif; color: #1c1c1c; background: #fff; margin: 0 auto; padding: 1rem;
  max-width: 72rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.2rem; margin-top: 2rem; border-top: 1px solid #ccc; padding-top: 1rem; }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 30rem), 1fr)); gap: 1.5rem; }
figure { margin: 0; } figure svg { width: 100%; height: auto; display: block; }
figcaption, .small { font-size: .85rem; color: #555; }
.table { overflow-x: auto; } table { border-collapse: collapse; font-variant-numeric: tabular-nums; margin: .5rem 0; }
th, td { padding: .2rem .6rem; text-align: right; white-space: nowrap; } th:first-child { text-align: left; }
thead th { border-bottom: 2px solid #888; } tbody tr:nth-child(even) { background: #f5f5f5; }
.published { color: #777; font-weight: normal; } details { margin-bottom: 1rem; }
h3 { font-size: 1rem; margin: 1.5rem 0 .5rem; }
@media (max-width: 40rem) { body { padding: .7rem; } .statistics { font-size: .7rem; } th, td { padding: .2rem .15rem; }
  .published { font-size: .65rem; } .statistics thead th { white-space: normal; } h1 { overflow-wrap: anywhere; } }
"""
MOST_SPANS = 20
MEANINGS = (
    "α: inclination to the vertical of the plane nearest to the markers. e_P: root mean square of their distances from "
    "that plane. e_C: root mean square of their distances, in the plane at the same x, from the nearest catenary."
)


def page(title: str, sections: list[Section], estimates: Sequence[tuple[str, Picture]] = ()) -> str:
    """The whole page as text; estimates: pictures of estimated lines, with the estimators' names."""
    body = "\n".join(line for section in sections for line in _section(section))
    body += "\n".join(_estimated(name, picture) for name, picture in estimates)
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{escape(title)}</h1>\n"
        f"{body}\n</body>\n</html>\n"
    )


def _estimated(name: str, picture: Picture) -> str:
    figure = f"<figure>{picture.svg}<figcaption>{escape(picture.caption)}</figcaption></figure>"
    return f'<section>\n<h2>Estimated by {escape(name)}</h2>\n<div class="figures">{figure}</div>\n</section>'


def _section(section: Section) -> Iterator[str]:
    cable = section.cable
    scenario = cable.recording.origin.scenario
    yield f"<section>\n<h2>{escape(cable.recording.name)}{escape(f' of {scenario}' if scenario else '')}</h2>"
    yield f"<p><strong>{escape(str(cable.durations))}</strong></p>"
    yield f"<h3>Statistics of {cable.statistics.frames_used} frames</h3>"
    yield _statistics(cable)
    yield f"<p>{escape(failures(cable))} {escape(noise(cable))}</p>"
    yield from _spans(cable)
    for spread in section.spreads:
        yield f'<h3>{escape(spread.title)}</h3>\n<div class="figures">'
        for picture in spread.pictures:
            yield f"<figure>{picture.svg}<figcaption>{escape(picture.caption)}</figcaption></figure>"
        yield "</div>"
    yield _facts(cable)
    yield "</section>"


def _table(header: Iterable[str], lines: Iterable[Iterable[str]], name: str) -> str:
    """A table whose first column names its rows; cells are HTML."""
    head = "".join(f'<th scope="col">{cell}</th>' for cell in header)
    body = "".join(
        f'<tr><th scope="row">{first}</th>{"".join(f"<td>{cell}</td>" for cell in cells)}</tr>\n'
        for first, *cells in lines
    )
    content = f"<thead><tr>{head}</tr></thead>\n<tbody>\n{body}</tbody>"
    return f'<div class="table"><table class="{name}">\n{content}</table></div>'


def _statistics(cable: Cable) -> str:
    header = [""]
    for title in INDICATORS.values():
        header.append(escape(title))
        if cable.published:
            header.append('<span class="published">publ&shy;ished</span>')
    lines = [[name, *map(escape, values)] for name, values in rows(cable)]
    table = _table(header, lines, "statistics")
    said = [MEANINGS]
    if cable.published is not None:
        said.append(f"Published: {cable.published.table} of {cable.published.source}.")
    return f'{table}<p class="small">{escape(" ".join(said))}</p>'


def _spans(cable: Cable) -> Iterator[str]:
    worst = sorted(sorted(cable.spans, key=lambda span: -span.worst)[:MOST_SPANS], key=lambda span: span.start_ns)
    if not worst:
        return
    title = "Where the catenary fails" if len(worst) == len(cable.spans) else f"The {MOST_SPANS} worst spans"
    lines = ([f"{s.start_ns / 1e9:.2f}", f"{s.end_ns / 1e9:.2f}", str(s.frames), f"{1e3 * s.worst:.4g}"] for s in worst)
    table = _table(["from [s]", "to [s]", "frames [1]", "largest e_C [mm]"], lines, "spans")
    yield f"<details><summary>{title} ({len(cable.spans)} in all)</summary>{table}</details>"


def _facts(cable: Cable) -> str:
    """How the numbers came about."""
    facts = [
        f"{cable.statistics.frames_used} of {cable.statistics.frames} frames used; method {cable.method}, "
        f"{cable.wall_s:.3g} s",
        *(f"{count} frames: {reason}" for reason, count in cable.fits.reasons().items()),
        *cable.fits.notes,
        f"markers from {cable.recording.frames.source}",
    ]
    return f'<ul class="small">{"".join(f"<li>{escape(fact)}</li>" for fact in facts)}</ul>'
