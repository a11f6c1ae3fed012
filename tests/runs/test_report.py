"""towline report: one page that is whole in itself, says what validity says, and whose axes have titles and units."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections import Counter
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from pipeline.analysis.figures import thinned
from pipeline.analysis.report import write
from pipeline.cli import main

ROOT = Path(__file__).parents[2]
POOL = str(ROOT / "scenarios" / "pool_chain.yaml")
INDICATORS = ("alpha_deg", "e_plane_mm", "e_catenary_mm")
VOID = {"meta", "br"}
SOFT_HYPHEN = "\xad"


class Page(HTMLParser):
    """Tags must close in order; gathers attributes and the cells of each table."""

    def __init__(self, text: str):
        super().__init__()
        self.open: list[str] = []
        self.attributes: list[tuple[str, str]] = []
        self.tables: dict[str, list[list[str]]] = {}
        self.table = ""
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.attributes += [(name, value or "") for name, value in attrs]
        if tag not in VOID:
            self.open.append(tag)
        if tag == "table":
            self.table = dict(attrs)["class"] or ""
            self.tables[self.table] = []
        elif tag == "tr":
            self.tables[self.table].append([])
        elif tag in ("th", "td"):
            self.tables[self.table][-1].append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if "th" in self.open or "td" in self.open:
            self.tables[self.table][-1][-1] += data.replace(SOFT_HYPHEN, "")


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> tuple[dict, str]:
    """The command's JSON and its page, of 30 s of the chain."""
    folder = tmp_path_factory.mktemp("report")
    log, out = folder / "chain.mcap", folder / "page.html"
    assert main(["run", POOL, "--until", "30s", "--out", str(log), "--json"]) == 0
    with pytest.MonkeyPatch.context() as patch:
        printed: list[str] = []
        patch.setattr("builtins.print", lambda *words, **_: printed.append(str(words[0])))
        assert main(["report", str(log), "-o", str(out), "--json"]) == 0
    return json.loads(printed[-1]), out.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page(made) -> Page:
    return Page(made[1])


def svgs(text: str) -> list[ElementTree.Element]:
    """The figures, read as strict XML."""
    found = re.findall(r"<svg.*?</svg>", text, re.DOTALL)
    spaced = [one.replace("<svg ", '<svg xmlns:xlink="x" ', 1) for one in found]
    return [ElementTree.fromstring(one) for one in spaced]


def test_needs_nothing_but_itself(made, page):
    """No link, image, font or script from elsewhere; the only addresses are namespace names, which nothing fetches."""
    fetching = [value for name, value in page.attributes if name in ("src", "href", "xlink:href", "srcset", "data")]
    assert all(value.startswith("#") for value in fetching)
    assert not re.search(r"url\((?!#)|@import|<script|<link", made[1])
    elsewhere = [value for name, value in page.attributes if "://" in value and not name.startswith("xmlns")]
    assert elsewhere == []


def test_identifiers_are_unique_and_references_meet_them(page):
    names = Counter(value for name, value in page.attributes if name == "id")
    assert [name for name, count in names.items() if count > 1] == []
    wanted = {value[1:] for name, value in page.attributes if name in ("href", "xlink:href")}
    wanted |= {name for _, value in page.attributes for name in re.findall(r"url\(#([^)]*)\)", value)}
    assert wanted <= set(names)


def test_reads_on_a_phone(made):
    assert '<meta name="viewport" content="width=device-width, initial-scale=1">' in made[1]
    assert "figure svg { width: 100%; height: auto;" in made[1]


def test_statistics_are_those_of_the_json(made, page):
    cable = made[0]["cables"]["markers"]
    header, *lines = page.tables["statistics"]
    assert header == ["", "α [°]", "published", "e_P [mm]", "published", "e_C [mm]", "published"]
    assert [line[0] for line in lines] == ["mean", "min", "max", "median", "σ"]
    for line, row in zip(lines, ("mean", "min", "max", "median", "std"), strict=True):
        both = [source[name][row] for name in INDICATORS for source in (cable, cable["published"])]
        assert line[1:] == [f"{value:.3g}" for value in both]


def test_spans_are_those_of_the_json(made, page):
    spans = made[0]["cables"]["markers"]["fails"]
    rows = page.tables["spans"][1:]
    assert 0 < len(rows) == len(spans) <= 20
    for row, span in zip(rows, spans, strict=True):
        assert [float(row[0]), float(row[1])] == pytest.approx([span["start_s"], span["end_s"]], abs=0.005)
        assert row[2:] == [str(span["frames"]), f"{span['worst_mm']:.4g}"]


def test_each_axis_has_a_title_with_a_unit(made):
    """Two figures of the whole record and two of the close-up: 4 and 5 panels, each with a title for time and value."""
    figures = svgs(made[1])
    panels = [len([g for g in one.iter() if re.search(r"-axes_\d+$", g.get("id", ""))]) for one in figures]
    assert panels == [4, 5, 4, 5]
    for figure, count in zip(figures, panels, strict=True):
        texts = ["".join(one.itertext()) for one in figure.iter() if one.tag.endswith("text")]
        assert texts.count("time [s]") == count
        units = [text for text in texts if re.search(r"\[(°|mm|1/m|1|m/s|m/s²|m)\]", text)]
        assert len(units) == count
    assert all(any(child.tag.endswith("title") for child in one) for one in figures)


def test_validity_needs_neither_numba_nor_scipy_nor_pandas(made):
    """Once compiled: what they take to import would be most of the command's time."""
    code = (
        "import sys; from pipeline.cli import main; assert main(['validity', sys.argv[1]]) == 0; "
        "print(sorted({'numba', 'scipy', 'pandas', 'matplotlib'} & set(sys.modules)))"
    )
    words = [sys.executable, "-c", code, str(Path(made[0]["report"]).with_name("chain.mcap"))]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60, check=True, cwd=ROOT)
    assert done.stdout.strip() == "[]"


def test_same_log_same_figures(made, tmp_path):
    log = Path(made[0]["report"]).with_name("chain.mcap")
    assert main(["report", str(log), "-o", str(tmp_path / "again.html"), "--json"]) == 0
    again = (tmp_path / "again.html").read_text(encoding="utf-8")
    assert re.findall(r"<svg.*?</svg>", again, re.DOTALL) == re.findall(r"<svg.*?</svg>", made[1], re.DOTALL)


def test_window_is_drawn(made, tmp_path, capsys):
    log = str(Path(made[0]["report"]).with_name("chain.mcap"))
    assert main(["report", log, "-o", str(tmp_path / "a.html"), "--window", "2 s", "4", "--json"]) == 0
    assert "<h3>2 to 4 s</h3>" in (tmp_path / "a.html").read_text(encoding="utf-8")
    assert main(["report", log, "-o", str(tmp_path / "b.html"), "--window", "4", "2", "--json"]) == 1
    capsys.readouterr()
    assert main(["report", log, "-o", str(tmp_path / "b.html"), "--window", "20", "40"]) == 1
    assert "20 to 40 s is not within the record of markers, which goes from 0 to 30 s" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["a.html"]
    assert main(["report", log, "-o", str(tmp_path / "no" / "b.html"), "--json"]) == 1
    assert "cannot write the report: No such file" in capsys.readouterr().err


def test_no_page_is_replaced_unasked(made, tmp_path, capsys):
    log, out = str(Path(made[0]["report"]).with_name("chain.mcap")), tmp_path / "a.html"
    out.write_text("mine")
    assert main(["report", log, "-o", str(out)]) == 1
    assert f"{out} exists; give another name with --out, or --overwrite" in capsys.readouterr().err
    assert out.read_text() == "mine"
    assert main(["report", log, "-o", str(out), "--overwrite"]) == 0
    assert out.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


def test_failing_report_leaves_nothing(tmp_path, monkeypatch):
    """A full disk, as the operating system tells it, after part of the page was written."""

    def full(path: Path, text: str, encoding: str) -> None:
        path.write_bytes(text[:100].encode(encoding))
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(OSError, match="No space"):
        write(tmp_path / "a.html", "x" * 200)
    assert list(tmp_path.iterdir()) == []


def test_seconds_are_on_the_page_and_add_up_to_the_record(made):
    """Of 30 s at 50 Hz every frame stands for 20 ms, the first and the last for half: sums of the JSON's own frames."""
    cable = made[0]["cables"]["markers"]
    failing, holding, unknown = (cable[f"seconds_{name}"] for name in ("failing", "holding", "unknown"))
    assert failing + holding + unknown == pytest.approx(30.0, abs=1e-9)
    assert failing == pytest.approx(0.02 * sum(span["frames"] for span in cable["fails"]), abs=0.0201)
    # Besides the frames that were not used, those beyond the tolerance by what noise may explain (see test_ends).
    assert unknown >= 0.02 * (cable["frames"] - cable["frames_used"]) - 0.0201
    assert f"holds for {holding:.4g} s, fails for {failing:.4g} s, and for {unknown:.4g} s it is not known" in made[1]


def test_thinning_keeps_extremes_and_order():
    rng = np.random.default_rng(0)
    t, values = np.arange(50_000) * 0.02, rng.standard_normal(50_000)
    values[100:9_000] = np.nan
    values[33_333], values[44_444] = 50.0, -50.0
    x, y = thinned(t, values, 500)
    assert len(x) < 1_200
    assert (np.diff(x) >= 0).all()
    assert (np.nanmax(y), np.nanmin(y)) == (50.0, -50.0)
    assert set(zip(x[np.isfinite(y)], y[np.isfinite(y)], strict=True)) <= set(zip(t, values, strict=True))
    assert np.isnan(y[(x > 10) & (x < 170)]).all()
