"""Images that a log holds, shown again to the component that saw them and compared with those that it makes."""

from __future__ import annotations

import numpy as np

from components.contract import ImagePort, placed_images
from pipeline.graph import Graph, Node, Term
from pipeline.log.reader import Log
from pipeline.quantities import LATEST


class Film:
    """An image output's history as the log holds it, read forward."""

    def __init__(self, log: Log, name: str, port: ImagePort):
        self.port, self.count = port, log.image_count(name, port.name)
        self._images, self._at = log.images(name, port.name), -1
        self._now = np.empty(0, np.uint8)

    def image(self, k: int) -> np.ndarray:
        """The k-th image, t0's first; k may not go back."""
        while self._at < k:
            _, self._now = next(self._images)
            self._at += 1
        return self._now


class Pictures:
    """The images of a node: inputs shown to it from the log, and its outputs compared with the log's.

    differences: largest absolute difference [grey levels] by output; None for one that the log holds in no such shape.
    """

    def __init__(self, log: Log, graph: Graph, i: int, node: Node):
        self._terms = [(term, *_film(log, graph, term)) for term in graph.nodes[i].terms if term.is_image]
        before = {port.name: port.shape for port, _ in placed_images(graph.nodes[i].outputs)}
        self._outputs = list(placed_images(node.outputs))
        self._films = {
            port.name: Film(log, node.name, port)
            for port, _ in self._outputs
            if before.get(port.name) == port.shape and log.image_count(node.name, port.name)
        }
        zero = dict.fromkeys(self._films, 0.0)
        self.differences: dict[str, float | None] = {port.name: zero.get(port.name) for port, _ in self._outputs}

    @property
    def is_any(self) -> bool:
        """Whether it has images."""
        return bool(self._terms or self._outputs)

    def steps(self, ticks: np.ndarray) -> int:
        """How many of the steps that end these ticks the log holds all images for: an interrupted log may lack some."""
        last = min((film.count * period - 1 for _, film, period in self._terms), default=LATEST)
        known = int(np.searchsorted(ticks, last, side="right"))
        return min([known, *(film.count for film in self._films.values())])

    def show(self, u: np.ndarray, tick: int) -> None:
        """Put what it sees in the step that ends a tick into its inputs."""
        for term, film, period in self._terms:
            words = u[term.target : term.target + term.count]
            if term.delayed and tick == 0:
                words[:] = 0.0
            else:
                film.port.in_words(words)[...] = film.image((tick - term.delayed) // period)

    def compare(self, y: np.ndarray, step: int) -> None:
        """Compare the images among its outputs with the log's of that step."""
        for port, place in self._outputs:
            if port.name in self._films:
                apart = port.in_words(y[place]).astype(np.int16) - self._films[port.name].image(step)
                so_far = self.differences[port.name] or 0.0
                self.differences[port.name] = max(so_far, float(np.abs(apart).max()))


def _film(log: Log, graph: Graph, term: Term) -> tuple[Film, int]:
    """The image that a term reads, and its producer's period."""
    for node in graph.nodes:
        for port, place in placed_images(node.outputs):
            if node.start + place.start == term.source:
                return Film(log, node.name, port), node.period
    raise AssertionError(f"no image begins at {term.source}")
