"""A tab of the page: paragraphs and charts, in order."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape

from pipeline.analysis.page.charts import Chart


@dataclass(frozen=True)
class Tab:
    """name: of its address in the page. items: HTML, or charts."""

    name: str
    title: str
    items: Sequence[str | Chart]


def table(header: Iterable[str], lines: Iterable[Iterable[str]], name: str) -> str:
    """A table whose first column names its rows; cells are HTML."""
    head = "".join(f'<th scope="col">{cell}</th>' for cell in header)
    body = "".join(
        f'<tr><th scope="row">{first}</th>{"".join(f"<td>{cell}</td>" for cell in cells)}</tr>\n'
        for first, *cells in lines
    )
    content = f"<thead><tr>{head}</tr></thead>\n<tbody>\n{body}</tbody>"
    return f'<div class="table"><table class="{name}">\n{content}</table></div>'


def paragraph(text: str, kind: str = "") -> str:
    """Plain text as a paragraph."""
    return f"<p{f' class={chr(34)}{kind}{chr(34)}' if kind else ''}>{escape(text)}</p>"


def heading(text: str) -> str:
    """Of a part of a tab."""
    return f"<h3>{escape(text)}</h3>"
