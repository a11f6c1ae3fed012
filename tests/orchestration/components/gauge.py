"""Reads the mark's height from a picture, and gives a smaller picture of it on."""

import numpy as np

from components.contract import Component, ImagePort, Parameters, Port, Sizes, choice


class Gauge(Parameters):
    """The picture that it takes."""

    shape: tuple[int, ...] = choice("height, width and channels", (37, 51))


def step(t_ns, dt_ns, p, u, x, y, w, images_in, images_out):
    picture = images_in["picture"]
    grey = picture[:, :, 0] if picture.ndim == 3 else picture
    rows = np.flatnonzero((grey == 255).all(axis=1))
    x[0] = 0.5 * x[0] + float(picture.sum(dtype=np.int64))
    y[0], y[1] = rows.mean() if len(rows) else -1.0, x[0]
    images_out["half"] = np.ascontiguousarray(grey[::2, ::2])
    return 0


COMPONENT = Component(
    name="test.gauge",
    parameters=Gauge,
    inputs=lambda gauge: (ImagePort("picture", shape=gauge.shape),),
    outputs=lambda gauge: (
        Port("row", "pixel"),
        Port("trace", "1"),
        ImagePort("half", shape=tuple((n + 1) // 2 for n in gauge.shape[:2])),
    ),
    sizes=lambda _: Sizes(state=1),
    init=step,
    step=step,
    compiled=False,
)
