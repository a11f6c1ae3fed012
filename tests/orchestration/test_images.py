"""Images between Python components: what a consumer sees and when, what is refused, and what becomes of a bad image.

Authority: the wall that the camera draws, computed here again; DESIGN.md's time model, as for vectors.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from components.contract import ImagePort, Port, placed_images
from pipeline.conductor import Conductor
from pipeline.errors import StepError, WiringError
from pipeline.graph import Graph
from pipeline.sections import cut

SHAPE = (37, 51)
CAMERA = "cam: {model: ./camera.py, inputs: {height: 0}%s}"
GAUGE = "{model: ./gauge.py, inputs: {picture: %s}}"


def wall(number: int) -> np.ndarray:
    """The camera's image number `number`, counted from 1 at t0, of a mark at height 0."""
    row, column = np.mgrid[: SHAPE[0], : SHAPE[1]]
    mark = np.abs(row - 0.5 * SHAPE[0]) < 2.5
    return np.where(mark, 255, (column * 7 + row * 3 + number) % 200).astype(np.uint8)


def halves(graph: Graph, name: str, slice_ticks: int | None = None) -> list[np.ndarray]:
    """The images that a component of this name has put out, t0 first."""
    conductor, seen = Conductor(graph), []
    i = [node.name for node in graph.nodes].index(name)
    port, place = next(placed_images(graph.nodes[i].outputs))

    def take() -> None:
        for channel, rows in conductor.captured():
            if channel == i:
                seen.extend(port.in_words(row[1:][place]).copy() for row in rows)

    conductor.initialise()
    take()
    for _ in conductor.run(graph.ticks, lambda: slice_ticks):
        take()
    return seen


@pytest.mark.parametrize("slice_ticks", [None, 1])
@pytest.mark.parametrize(
    ("source", "numbers"),
    [
        # cam, due every 2 s:  t0 1  -  2  -  3  -  4      (number of its image; 0: black)
        ("cam.image", [1, 1, 2, 2, 3, 3, 4]),
        ("{from: cam.image, delay: true}", [0, 1, 1, 2, 2, 3, 3]),
    ],
)
def test_direct_and_delayed_wires_carry_what_they_carry_of_numbers(graph, source, numbers, slice_ticks):
    text = f"components:\n  {CAMERA % ', period: 2 s'}\n  late: {GAUGE % source}\n"
    seen = halves(graph(text), "late", slice_ticks)
    expected = [wall(n)[::2, ::2] if n else np.zeros((19, 26)) for n in numbers]
    assert len(seen) == len(expected)
    assert all(np.array_equal(a, b) for a, b in zip(seen, expected, strict=True))


def test_a_slower_consumer_sees_the_latest(graph):
    gauge = GAUGE.replace("gauge.py", "gauge.py, period: 3 s") % "cam.image"
    seen = halves(graph(f"components:\n  {CAMERA % ''}\n  slow: {gauge}\n"), "slow")
    assert all(np.array_equal(a, wall(n)[::2, ::2]) for a, n in zip(seen, (1, 4, 7), strict=True))


def test_images_are_written_only_and_wholly(graph):
    """With all of the board full of other bytes before a step, the same pixels, and zeros behind the last one."""
    boards = []
    for value in (0.0, np.nan, -1.0):
        conductor = Conductor(graph(f"components: {{{CAMERA % ''}}}"))
        board = conductor.memory.tables.board
        board[:] = value
        conductor.initialise()
        boards.append([board.tobytes()])
        board[:] = value
        list(conductor.run(1))
        boards[-1].append(board.tobytes())
    assert boards[0] == boards[1] == boards[2]
    pixels = SHAPE[0] * SHAPE[1]
    assert boards[0][1][8 : 8 + pixels] == wall(2).tobytes()
    assert boards[0][1][8 + pixels :] == bytes(-pixels % 8)


def test_components_with_images_are_sections_of_their_period(graph):
    """On one host as on several, so that pixels travel when a picture is taken, and not in every tick."""
    camera = CAMERA.replace("height: 0", "height: a.n") % ", period: 2 s"
    gauge, fast = GAUGE.replace("gauge.py", "gauge.py, period: 2 s"), GAUGE
    wired = f"{gauge % 'cam.image'}\n  fast: {fast % 'cam.image'}"
    built = graph(f"components:\n  a: {{model: ./counter.py}}\n  {camera}\n  gauge: {wired}\n")
    sections = cut(built, ["one"] * 4)
    assert [section.nodes for section in sections] == [(0,), (1, 2), (3,)]
    assert [(section.host, section.stage, section.periods) for section in sections] == [
        ("one", 0, (1,)),
        ("one", 1, (2,)),
        ("one", 2, (1,)),
    ]


BROKEN = {
    "missing": (None, "its output image is missing; expected an array of uint8, (37, 51) in images_out['image']"),
    "type": (
        np.zeros(SHAPE),
        "its output image is an array of float64, (37, 51); expected an array of uint8, (37, 51)",
    ),
    "shape": (np.zeros((51, 37), np.uint8), "its output image is an array of uint8, (51, 37); expected an array of"),
    "list": ([[0] * 51] * 37, "its output image is a list; expected an array of uint8, (37, 51)"),
}


def with_step(graph: Graph, i: int, step) -> Graph:
    """The graph with another step of node i."""
    node = graph.nodes[i]
    nodes = list(graph.nodes)
    nodes[i] = replace(node, component=replace(node.component, step=step))
    return replace(graph, nodes=tuple(nodes))


def stopped_by(graph: Graph) -> str:
    conductor = Conductor(graph)
    conductor.initialise()
    with pytest.raises(StepError) as caught:
        list(conductor.run(graph.ticks))
    return str(caught.value)


@pytest.mark.parametrize(("image", "text"), BROKEN.values(), ids=BROKEN)
def test_a_bad_image_stops_the_run_with_a_word(graph, image, text):
    def step(t_ns, dt_ns, p, u, x, y, w, images_in, images_out):
        if image is not None:
            images_out["image"] = image
        return 0

    said = stopped_by(with_step(graph(f"components: {{{CAMERA % ''}}}"), 0, step))
    assert said.startswith(f"cam stopped the run at t = 1 s: {text}")


def test_an_image_of_another_name_is_refused(graph):
    def step(t_ns, dt_ns, p, u, x, y, w, images_in, images_out):
        images_out["imgae"] = wall(1)
        return 0

    said = stopped_by(with_step(graph(f"components: {{{CAMERA % ''}}}"), 0, step))
    assert "it put an image 'imgae' out, and has no such output" in said


def test_what_is_seen_cannot_be_changed(graph):
    def step(t_ns, dt_ns, p, u, x, y, w, images_in, images_out):
        images_in["picture"][:] = 0
        return 0

    text = f"components:\n  {CAMERA % ''}\n  gauge: {GAUGE % 'cam.image'}\n"
    assert "its Python code raised ValueError: assignment destination is read-only" in stopped_by(
        with_step(graph(text), 1, step)
    )


HEAD = "duration: 1 s\nstep: 20 ms\ncomponents:\n  src: {model: ./components/source.py}\n"
CAM = "  cam: {model: ./components/camera.py, inputs: {height: 0}}\n"
EYE = "  eye: {model: ./components/camera.py, inputs: {height: 0}, parameters: {is_color: true}}\n"
GREY, COLOR = "a grey image, 51 x 37 pixels", "an RGB image, 51 x 37 pixels"
REFUSED = {  # what feeds an image (6:60 in the text), and the message
    "a number": ("src.pull", f"src.pull is a single number in N; gauge.picture expects {GREY}"),
    "a list of numbers of its shape": ("src.nodes", f"src.nodes is a list of 4 x 3 in m; gauge.picture expects {GREY}"),
    "another shape": ("eye.image", f"eye.image is {COLOR}; gauge.picture expects {GREY}"),
    "a slice": ("'cam.image[:3]'", "cam.image is an image, which has no slices; expected cam.image"),
    "a constant": ("0", f"a constant; gauge.picture expects {GREY}, from a signal"),
    "a gain": ("{from: cam.image, gain: 2}", "gain goes to numbers; an image is wired as it is, and is black before"),
    "an initial": ("{from: cam.image, delay: true, initial: 1}", "initial goes to numbers; an image is wired as it is"),
    "a sum": ("{sum: [cam.image, cam.image]}", "images cannot be added; expected one signal"),
    "a sum with a bundle": ("cam", "cam is a bundle; expected one of its ports: time, image"),
}


@pytest.mark.parametrize(("source", "text"), REFUSED.values(), ids=REFUSED)
def test_what_cannot_be_wired_to_an_image(message, source, text):
    gauge = f"  gauge: {{model: ./components/gauge.py, inputs: {{picture: {source}}}}}\n"
    said = message(HEAD + CAM + EYE + gauge)
    assert " components.gauge.inputs.picture" in said
    assert said.startswith("7:")
    assert text in said


def test_an_image_feeds_no_numbers_and_takes_none(message):
    relay = "  relay: {model: ./components/relay.py, inputs: {in: cam.image}}\n"
    expected = f"6:54 components.relay.inputs.in: cam.image is {GREY}; relay.in expects a single number"
    assert message(HEAD + CAM + relay) == expected
    event = "events: [{at: 0.5 s, add: {cam.image: 1}}]\n"
    assert "cam.image is an image; nothing can be added to it" in message(HEAD + CAM + event)
    bare = "  gauge: {model: ./components/gauge.py}\n"
    assert f"'picture' is not wired; expected {GREY}" in message(HEAD + bare)


@pytest.mark.parametrize(
    ("ports", "compiled", "text"),
    [
        ((ImagePort("i", shape=(2, 3)),), True, "'i' is an image, which only Python components can have; expected"),
        (
            (ImagePort("i", shape=(2, 3, 2)),),
            False,
            "output 'i' is an image of (2, 3, 2); expected (height, width) for",
        ),
        ((ImagePort("i", shape=(0, 3)),), False, "output 'i' is an image of (0, 3); expected (height, width) for grey"),
        ((ImagePort("i", "m", (2, 3)),), False, "output 'i' is an image in m; expected 'pixel'"),
        (
            (ImagePort("i", shape=(2, 3)), Port("n", "1")),
            False,
            "output 'n' stands behind an image; expected images last",
        ),
    ],
)
def test_ports_that_are_refused(graph, monkeypatch, ports, compiled, text):
    from pipeline import wiring

    lay_out_of = wiring._Wiring._lay_out

    def declared(self, instance):
        kind = replace(instance.component, outputs=lambda _: ports, compiled=compiled)
        lay_out_of(self, replace(instance, component=kind))

    monkeypatch.setattr(wiring._Wiring, "_lay_out", declared)
    with pytest.raises(WiringError) as caught:
        graph(f"components: {{{CAMERA % ''}}}")
    assert text in str(caught.value)
