"""The report's page in a real browser: it loads, its slider moves the line, its figures have data, a phone shows it.

Driven by Chromium's own protocol over two pipes, so that it needs neither a port nor a library. Without a Chromium,
which .ci/run installs, these tests are skipped.
"""

from __future__ import annotations

import json
import os
import select
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pipeline.cli import main
from pipeline.log.reader import open_log

ROOT = Path(__file__).parents[2]
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
UNTIL_S, PATIENCE_S = 12.0, 60.0
PHONE = {"width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": True}
DESK = {"width": 1300, "height": 900, "deviceScaleFactor": 1, "mobile": False}
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium on this machine: apt-get install chromium")


class Browser:
    """One page of a headless Chromium, by its debugging protocol: messages parted by NUL on descriptors 3 and 4."""

    def __init__(self, profile: str):
        (theirs, self._write), (self._read, back) = os.pipe(), os.pipe()
        options = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run"]
        words = [str(CHROMIUM), *options, "--remote-debugging-pipe", f"--user-data-dir={profile}", "about:blank"]
        moved = 'exec 3<&"$1" 4>&"$2"; shift 2; exec "$@"'
        with open(os.devnull, "w") as nowhere:
            self._process = subprocess.Popen(
                ["bash", "-c", moved, "_", str(theirs), str(back), *words],
                pass_fds=(theirs, back),
                stdout=nowhere,
                stderr=nowhere,
            )
        os.close(theirs)
        os.close(back)
        self._sent, self._left, self.events = 0, b"", []
        self._session: str | None = None
        target = next(one for one in self.call("Target.getTargets")["targetInfos"] if one["type"] == "page")
        attached = self.call("Target.attachToTarget", targetId=target["targetId"], flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """The result of a command; what else comes meanwhile is kept in `events`."""
        self._sent += 1
        message: dict[str, Any] = {"id": self._sent, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        while True:
            found = self._next()
            if found.get("id") == self._sent:
                assert "error" not in found, found
                return found["result"]
            self.events.append(found)

    def _next(self) -> dict[str, Any]:
        while b"\0" not in self._left:
            assert select.select([self._read], [], [], PATIENCE_S)[0], "the browser does not answer"
            part = os.read(self._read, 1 << 20)
            assert part, "the browser has ended"
            self._left += part
        message, _, self._left = self._left.partition(b"\0")
        return json.loads(message)

    def open(self, address: str) -> None:
        """Load a page to its end."""
        self.call("Page.navigate", url=address)
        while not any(event.get("method") == "Page.loadEventFired" for event in self.events):
            self.events.append(self._next())

    def value(self, expression: str) -> Any:
        """What a JavaScript expression gives; its promise is awaited."""
        found = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in found, found["exceptionDetails"]
        return found["result"].get("value")

    def mouse(self, *steps: tuple[str, float, float]) -> None:
        """Moves, presses and releases of the left button."""
        for kind, x, y in steps:
            button = "none" if kind == "mouseMoved" else "left"
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button=button, clickCount=1)

    def middle(self, selector: str) -> tuple[float, float]:
        """Of an element, in pixels of the window."""
        rect = f"(({{x, y, width, height}}) => [x + width / 2, y + height / 2])(document.querySelector('{selector}')"
        x, y = self.value(f"{rect}.getBoundingClientRect())")
        return x, y

    def drawn(self) -> None:
        """Wait for the page's next frame."""
        self.value("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(0))))")

    def close(self) -> None:
        """End the browser."""
        self._session = None
        os.write(self._write, json.dumps({"id": 0, "method": "Browser.close"}).encode() + b"\0")
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        os.close(self._write)
        os.close(self._read)


@pytest.fixture(scope="module")
def log(tmp_path_factory) -> Path:
    """The scene with everything in it, shortly."""
    path = tmp_path_factory.mktemp("page") / "scene.mcap"
    scenario = str(ROOT / "scenarios" / "dp_rov_tether.yaml")
    words = ["--until", f"{UNTIL_S} s", "--bus", "local", "--out", str(path), "--json"]
    assert main(["run", scenario, *words]) == 0
    assert main(["report", str(path), "--json"]) == 0
    return path


@pytest.fixture(scope="module")
def browser(log) -> Iterator[Browser]:
    """One for all tests, with the page open; what the tests do to it they undo."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = Browser(profile)
        try:
            browser.call("Emulation.setDeviceMetricsOverride", **DESK)
            browser.open(log.with_suffix(".html").as_uri())
            yield browser
        finally:
            browser.close()


@pytest.fixture
def page(browser) -> Browser:
    """The page at its beginning, as it opens."""
    browser.value(
        "towline.open('overview'); player.play(false); player.setWindow(...data.t); player.setTime(data.t[0])"
    )
    browser.drawn()
    return browser


def test_loads_alone_and_without_errors(page, log):
    """Every tab opened: no exception, no word on the console, nothing fetched but the page itself."""
    for name in page.value("[...document.querySelectorAll('[role=tab]')].map((tab) => tab.id)"):
        page.value(f"document.getElementById('{name}').click()")
        page.drawn()
    by_method: dict[str, list[dict]] = {}
    for event in page.events:
        by_method.setdefault(event.get("method", ""), []).append(event["params"])
    assert not {"Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded"} & set(by_method)
    asked = {event["request"]["url"] for event in by_method["Network.requestWillBeSent"]}
    assert asked == {log.with_suffix(".html").as_uri()}


def test_tabs_are_those_that_the_log_has_data_of(page):
    names = page.value("[...document.querySelectorAll('[role=tab]')].map((tab) => tab.textContent)")
    bodies = ["Tensions", "Motion", "Control", "Thrusters", "Estimator", "Estimated line", "Power bonds", "Weather"]
    assert names == ["Overview", "Catenary", *bodies]
    shown = page.value("[...document.querySelectorAll('[role=tabpanel]')].filter((one) => !one.hidden).length")
    assert shown == 1


def test_every_figure_has_titles_and_data(page):
    """Curves have points, and pixels of their colour on the canvas; axes have a unit."""
    seen = page.value("""(() => {
      const found = [];
      for (const tab of document.querySelectorAll('[role=tab]')) {
        tab.click();
        for (const chart of towline.charts.filter((one) => one.visible())) {
          const { base, spec } = chart;
          const pixels = base.getContext('2d').getImageData(0, 0, base.width, base.height).data;
          const inked = (color) => {
            const [r, g, b] = [1, 3, 5].map((i) => parseInt(color.slice(i, i + 2), 16));
            let count = 0;
            for (let i = 0; i < pixels.length; i += 4) {
              const off = Math.abs(pixels[i] - r) + Math.abs(pixels[i + 1] - g) + Math.abs(pixels[i + 2] - b);
              count += off < 60 && pixels[i + 3] > 100;
            }
            return count;
          };
          const curves = chart.series.map((one) => ({
            points: one.v.filter(Number.isFinite).length, ink: inked(one.color), kind: one.kind }));
          found.push({ title: spec.title, x: spec.x, y: spec.y, lanes: spec.lanes.length, curves });
        }
      }
      return found;
    })()""")
    assert len(seen) == page.value("data.charts.length") > 40
    for one in seen:
        assert one["x"] == "time [s]"
        assert one["lanes"] or "[" in one["y"], one
        assert one["lanes"] or any(curve["points"] for curve in one["curves"]), one["title"]
        # A curve hidden wholly behind another one leaves no ink; a figure without any ink draws nothing.
        known = [curve for curve in one["curves"] if curve["points"] > 1]
        assert not known or sum(curve["ink"] for curve in known) > 20, one["title"]


def test_slider_moves_the_line(page):
    """A press on the slider's middle: time, the line's pixels and the picture change; the values follow."""
    state = "({ time: player.time, points: towline.scene.points.flat(), picture: towline.scene.canvas.toDataURL() })"
    before = page.value(state)
    x, y = page.middle("#time")
    page.mouse(("mousePressed", x, y), ("mouseReleased", x, y))
    page.drawn()
    after = page.value(state)
    assert before["time"] == 0.0
    assert after["time"] == pytest.approx(UNTIL_S / 2, abs=0.1)
    moved = np.abs(np.array(after["points"]) - np.array(before["points"])).reshape(-1, 3)[:, :2]
    assert moved.max() > 0.3
    assert after["picture"] != before["picture"]
    assert page.value("document.getElementById('now').textContent") == f"{after['time']:.1f} s"


def test_line_stands_where_the_log_says(page, log):
    """Half a step of the 16 bits, of each axis' range, at a time of a message."""
    with open_log(log) as one:
        t, nodes = one.times("tether") / 1e9, one.port("tether", "nodes")
    for i in (0, len(t) // 3, len(t) - 1):
        found = np.array(page.value(f"Array.from(places.at(data.scene.lines[0], {t[i]}))")).reshape(-1, 3)
        step = np.array(page.value("data.scene.lines[0].span")) / 65535
        assert (np.abs(found - nodes[i]) <= 0.51 * step + 1e-9).all()


def test_dragging_turns_and_playing_goes_on(page):
    x, y = page.middle("#scene")
    before = page.value("towline.scene.points.flat()")
    page.mouse(("mousePressed", x, y), ("mouseMoved", x + 80, y + 30), ("mouseReleased", x + 80, y + 30))
    page.drawn()
    assert np.abs(np.array(page.value("towline.scene.points.flat()")) - before).max() > 5.0
    page.value("document.getElementById('play').click()")
    assert page.value("new Promise((done) => setTimeout(() => done(player.time), 300))") > 0.05
    page.value("document.getElementById('play').click()")
    still = page.value("player.time")
    assert page.value("new Promise((done) => setTimeout(() => done(player.time), 100))") == still


def test_pointer_shows_values_and_zooms(page, log):
    """The value beside the pointer is one the log has near that time: a thinned curve skips between its extremes."""
    page.value("document.getElementById('tab-tensions').click()")
    page.drawn()
    left, top, width = page.value(
        "(({x, y, width}) => [x, y, width])(towline.charts.find((one) => one.visible()).over.getBoundingClientRect())"
    )
    x, y = left + 0.6 * width, top + 60.0
    page.mouse(("mouseMoved", x, y))
    state = (
        "(({hover, series}) => [hover, Number(series[1].label.textContent)])(towline.charts.find((c) => c.visible()))"
    )
    time, value = page.value(state)
    with open_log(log) as one:
        t, force = one.times("tether") / 1e9, np.linalg.norm(one.port("tether", "force_a"), axis=1)
    near = force[np.abs(t - time) < 0.1]
    assert near.min() * 0.999 <= value <= near.max() * 1.001
    page.mouse(("mousePressed", x, y), ("mouseMoved", x + 100, y), ("mouseReleased", x + 100, y))
    from_s, to_s = page.value("player.window")
    assert from_s == pytest.approx(time, abs=0.05)
    assert from_s < to_s < UNTIL_S
    page.value("document.getElementById('whole').click()")
    assert page.value("player.window") == [0.0, UNTIL_S]


def test_a_phone_shows_it(page):
    """Nothing is wider than the screen; wide tables scroll within themselves."""
    page.call("Emulation.setDeviceMetricsOverride", **PHONE)
    try:
        for name in page.value("[...document.querySelectorAll('[role=tab]')].map((tab) => tab.id)"):
            page.value(f"document.getElementById('{name}').click()")
            page.drawn()
            assert page.value("document.documentElement.scrollWidth") <= PHONE["width"], name
        page.value("document.getElementById('tab-overview').click()")
        page.drawn()
        assert page.value("towline.scene.canvas.width") > PHONE["width"]  # drawn at the screen's own resolution
    finally:
        page.call("Emulation.setDeviceMetricsOverride", **DESK)
