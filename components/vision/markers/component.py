"""Binds the search for markers to the contract."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from components.contract import HEADER, Component
from components.vision.markers import finding, model


@lru_cache(maxsize=4)
def _task(numbers: bytes) -> finding.Task:
    return model.task_of(np.frombuffer(numbers))


def write(q: np.ndarray, found: finding.Found, y: np.ndarray) -> None:
    """Write all outputs; q: the parameters' vector."""
    position = np.column_stack([found.plane[:, 0], np.where(found.valid, q[model.PLANE], 0.0), found.plane[:, 1]])
    parts = [found.pixel, found.pixel_covariance, position, found.valid, found.covariance]
    y[:] = np.concatenate([*(np.ravel(part) for part in parts), q[model.SCALES : model.SCALES + 2], found.shift])


def look(h: float, q: np.ndarray, x: np.ndarray, image: np.ndarray) -> finding.Found:
    """The markers of an image, h after the last one; 0 for the first."""
    if model.METHODS[int(q[model.METHOD])] == "best":
        if h == 0.0:
            finding.begin(x)
        return finding.find(_task(q.tobytes()), image, x, h)
    from components.vision.markers import order  # OpenCV, which method best does without

    if h == 0.0:
        order.keep_reference(image, x)
    affinity, deviation = model.affinity_of(q)
    first, markers = q[model.FIRST : model.FIRST + 2], int(q[model.MARKERS])
    return order.find(affinity, deviation, first, markers, image, order.reference_of(x, image.shape))


def init(t_ns, dt_ns, p, u, x, y, w, images_in, images_out):
    """The first image."""
    write(p[HEADER:], look(0.0, p[HEADER:], x, images_in["image"]), y)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w, images_in, images_out):
    """The image at the end of the step."""
    write(p[HEADER:], look(dt_ns * 1e-9, p[HEADER:], x, images_in["image"]), y)
    return 0


COMPONENT = Component(
    name="vision.markers",
    parameters=model.Markers,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    compiled=False,
    terms=model.terms,
    assumptions=(
        "The line moves in one plane; markers are round, of one size, brighter than line and background, and do not "
        "touch in the image; after all were lost, they come back nearer to their own places than to their neighbours'."
    ),
)
