"""towline report: one page that is whole in itself, says what validity says, and whose axes have titles and units."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections import Counter
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from pipeline.analysis.page.charts import Window, thinned, when
from pipeline.analysis.page.document import document
from pipeline.analysis.report import write
from pipeline.cli import main

ROOT = Path(__file__).parents[2]
POOL = str(ROOT / "scenarios" / "pool_chain.yaml")
INDICATORS = ("alpha_deg", "e_plane_mm", "e_catenary_mm")
VOID = {"meta", "br", "input"}
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


def data(text: str) -> str:
    """What the page's figures are drawn from, as it stands there."""
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    assert found
    return found[1]


def test_needs_nothing_but_itself(made, page):
    """No link, image, font or script from elsewhere, and no address at all."""
    fetching = [value for name, value in page.attributes if name in ("src", "href", "xlink:href", "srcset", "data")]
    assert fetching == []
    assert not re.search(r"url\(|@import|<link|<script [^>]*src|import\(|fetch\(|XMLHttpRequest|WebSocket", made[1])
    assert "://" not in made[1].replace(data(made[1]), "")


def test_identifiers_are_unique_and_references_meet_them(page):
    names = Counter(value for name, value in page.attributes if name == "id")
    assert [name for name, count in names.items() if count > 1] == []
    wanted = {value[1:] for name, value in page.attributes if name in ("href", "xlink:href")}
    wanted |= {name for _, value in page.attributes for name in re.findall(r"url\(#([^)]*)\)", value)}
    assert wanted <= set(names)


def test_reads_on_a_phone(made):
    assert '<meta name="viewport" content="width=device-width, initial-scale=1">' in made[1]
    assert "@media (max-width: 48rem)" in made[1]


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
        assert row[2:4] == [str(span["frames"]), f"{span['worst_mm']:.4g}"]
        assert (row[4], span["cause"]) == ("drag by its own motion", "motion")


def test_each_axis_has_a_title_with_a_unit(made):
    """Figures 4 to 7 of Drupt et al. 2022 among them: indicators, markers, the moving end."""
    charts = json.loads(data(made[1]))["charts"]
    titles = [chart["y"] for chart in charts]
    assert all(chart["x"] == "time [s]" for chart in charts)
    assert all(re.search(r"\[(°|mm|1/m|1|m/s|m/s²|m|N|%)\]", title) for title in titles)
    wanted = ("α [°]", "e_P [mm]", "e_C [mm]", "C [1/m]", "N [1]", "index [1]", "speed [m/s]", "acceleration [m/s²]")
    assert all(any(title.endswith(one) for title in titles) for one in (*wanted, "ends apart d [m]", "tension [N]"))


def test_spans_are_shaded_where_the_json_has_them(made):
    charts = json.loads(data(made[1]))["charts"]
    bands = next(chart["bands"] for chart in charts if chart["title"] == "Distance from the catenary")
    spans = made[0]["cables"]["markers"]["fails"]
    assert bands == [[round(span["start_s"], 4), round(span["end_s"], 4)] for span in spans]


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
    assert data((tmp_path / "again.html").read_text(encoding="utf-8")) == data(made[1])


def test_window_is_drawn(made, tmp_path, capsys):
    log = str(Path(made[0]["report"]).with_name("chain.mcap"))
    assert main(["report", log, "-o", str(tmp_path / "a.html"), "--window", "2 s", "4", "--json"]) == 0
    assert json.loads(data((tmp_path / "a.html").read_text(encoding="utf-8")))["window"] == [2.0, 4.0]
    assert main(["report", log, "-o", str(tmp_path / "b.html"), "--window", "4", "2", "--json"]) == 1
    capsys.readouterr()
    assert main(["report", log, "-o", str(tmp_path / "b.html"), "--window", "20", "40"]) == 1
    assert "20 to 40 s is not within the record of chain.mcap, which goes from 0 to 30 s" in capsys.readouterr().err
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


def test_times_when_it_is_so_close_gaps_that_no_screen_shows():
    t = np.arange(0.0, 100.0, 0.01)
    so = (t % 1.0 < 0.97) & (t < 50.0)
    spans = when(t, so)
    assert len(spans) == 1
    assert spans[0] == pytest.approx((0.0, 49.97), abs=0.02)
    assert when(t, t > 200.0) == []
    assert when(t, t > -1.0) == [(0.0, t[-1])]
    assert len(when(t, t % 10.0 < 5.0)) == 10


def test_a_log_without_lines_has_a_page_too(run, tmp_path):
    """Bodies and what moved; no catenary. A line's table of markers has no log's tabs."""
    log = run(
        "{ball: {model: vessel.mass, parameters: {mass: 2 kg, weight: [0 N, 0 N, 1 N], position: [0 m, 0 m, 3 m]}}}"
    )
    assert main(["report", str(log.path), "-o", str(tmp_path / "ball.html"), "--json"]) == 0
    text = (tmp_path / "ball.html").read_text(encoding="utf-8")
    assert [one["name"] for one in json.loads(data(text))["scene"]["bodies"]] == ["ball"]
    assert 'id="tab-catenary"' not in text
    assert f" · run at {log.metadata('result')['real_time_factor']} times real time · " in text


def test_a_torn_log_without_lines_is_told_of(run, tmp_path, capsys):
    log = run("{ball: {model: vessel.mass, parameters: {mass: 2 kg, position: [0 m, 0 m, 3 m]}}}")
    torn = tmp_path / "torn.mcap"
    content = log.path.read_bytes()
    torn.write_bytes(content[: len(content) // 2])
    assert main(["report", str(torn)]) == 0
    assert "was interrupted: readable up to" in capsys.readouterr().err
    assert "was interrupted: readable up to" in torn.with_suffix(".html").read_text(encoding="utf-8")
    torn.write_bytes(b"hello")
    assert main(["report", str(torn), "--overwrite"]) == 1
    assert "the file is not MCAP" in capsys.readouterr().err


ODD = """
from components.contract import Component, Parameters, Port

class Nothing(Parameters):
    pass

def init(t_ns, dt_ns, p, u, x, y, w):
    for i in range(len(y)):
        y[i] = i % 7
    return 0

NAMES = (
    "tension force_a thrust power running limit.x surface velocity position attitude valid payout_rate stored "
    "error.position error.heading demand.force demand.moment validity.odd"
)
PORTS = tuple(Port(name, "N" if name == "thrust" else "1", (1,)) for name in NAMES.split())
LINE = Port("nodes", "m", (4, 3), "NED")
COMPONENT = Component(
    name="odd",
    parameters=Nothing,
    inputs=lambda _: (),
    outputs=lambda _: (*PORTS, LINE),
    init=init,
    step=init,
    compiled=False,
)
"""


def test_known_names_with_other_shapes(tmp_path, monkeypatch):
    """A user's own component may call one number what ours have three of."""
    monkeypatch.chdir(tmp_path)
    Path("odd.py").write_text(ODD)
    Path("odd.yaml").write_text("duration: 1 s\nstep: 100 ms\ncomponents: {odd: {model: ./odd.py}}\n")
    assert main(["run", "odd.yaml", "--out", "odd.mcap"]) == 0
    assert main(["report", "odd.mcap"]) == 0
    assert 'id="tab-tensions"' in Path("odd.html").read_text(encoding="utf-8")


def test_data_end_no_script_and_open_none():
    """In a script, `<!--<script>` would hide the end of it: HTML, 13.2.5.20, script data double escaped state."""
    whole = Window(0.0, 1.0)
    page = document("<!--<script>", "", [], None, whole, None, [(0.5, "</script><!--<script>")])
    assert page.count("<script") == page.count("</script>") == 2
    assert "<!--" not in page


def test_a_table_of_markers_has_a_page(made, tmp_path):
    log = Path(made[0]["report"]).with_name("chain.mcap")
    assert main(["export", str(log), "--format", "csv", "-o", str(tmp_path), "--json"]) == 0
    assert main(["report", str(tmp_path / "markers.csv"), "-o", str(tmp_path / "m.html"), "--json"]) == 0
    text = (tmp_path / "m.html").read_text(encoding="utf-8")
    found = json.loads(data(text))
    assert re.findall(r'id="tab-(\w+)"', text) == ["overview", "catenary"]
    assert found["scene"]["lines"][0]["n"] == 12
    assert found["t"] == [0.0, 30.0]
