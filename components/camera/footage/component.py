"""Binds a film to the contract."""

from math import floor

import numpy as np

from components.camera.footage import film, model
from components.camera.footage.faults import FilmError, MissingImage
from components.contract import HEADER, Component

WIDTH, HEIGHT, RATE, START, AT_END, MISSING, PATH = range(HEADER, HEADER + 7)
ENDED = 1
ROUNDING = 1e-6  # of an image: times are whole nanoseconds


def show(t_ns, dt_ns, p, u, x, y, w, images_in, images_out):
    """The image of the film at t_ns, both for init and step."""
    path = bytes(int(b) for b in p[PATH:]).decode()
    reel = film.open_film(path)
    k, expected = floor((t_ns * 1e-9 + p[START]) * p[RATE] + ROUNDING), (int(p[HEIGHT]), int(p[WIDTH]))
    if k >= reel.count:
        if model.ENDS[int(p[AT_END])] == "stop":
            return ENDED
        k = reel.count - 1
    y[0], y[1] = k, 1.0
    try:
        image = reel.frame(k)
    except MissingImage:
        if model.MISSING[int(p[MISSING])] == "stop":
            raise
        y[1] = 0.0
        images_out["image"] = np.zeros(expected, np.uint8)
        return 0
    if image.shape != expected:
        raise FilmError(
            f"image {k} of {path} has {image.shape[1]} x {image.shape[0]} pixels; "
            f"expected {expected[1]} x {expected[0]} (width, height)"
        )
    images_out["image"] = image
    return 0


COMPONENT = Component(
    name="camera.footage",
    parameters=model.Footage,
    outputs=model.outputs,
    init=show,
    step=show,
    status_text={ENDED: "the film has ended: end the run before it (duration), or set at_end to hold"},
    compiled=False,
    assumptions=(
        "The film's images are equally spaced in time; damage within a video's frame is hidden by its decoder."
    ),
)
