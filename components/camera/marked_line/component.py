"""Binds the rendered camera to the contract."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from components.camera.marked_line import model
from components.camera.marked_line.rendering import Setting, Still, paint, render
from components.contract import HEADER, SEED_HIGH, SEED_LOW, Component

COUNTER = 0  # in x: images taken before this one


@lru_cache(maxsize=4)
def _painted(scene: bytes, seed: tuple[float, float]) -> tuple[Setting, Still]:
    """The scene of the parameters' numbers behind the sensor's, and what stands still in it: the same for the same."""
    setting = model.setting_of(np.concatenate([np.zeros(model.SENSOR), np.frombuffer(scene)]), seed)
    return setting, paint(setting)


def take_image(t_ns, p, u, x, y, images_out):
    """Render the image at t_ns and write the markers' truth."""
    q = p[HEADER:]
    setting, still = _painted(q[model.SENSOR :].tobytes(), (float(p[SEED_HIGH]), float(p[SEED_LOW])))
    sensor, level = model.sensor_of(q)
    seen = render(setting, still, sensor, level, u.reshape(-1, 3), t_ns * 1e-9, int(x[COUNTER]))
    y[:] = np.concatenate([seen.position.ravel(), seen.pixel.ravel(), seen.visible])
    images_out["image"] = seen.image
    return 0


def init(t_ns, dt_ns, p, u, x, y, w, images_in, images_out):
    """The first image."""
    x[COUNTER] = 0.0
    return take_image(t_ns, p, u, x, y, images_out)


def step(t_ns, dt_ns, p, u, x, y, w, images_in, images_out):
    """The image at the end of the step."""
    x[COUNTER] += 1.0
    return take_image(t_ns, p, u, x, y, images_out)


COMPONENT = Component(
    name="camera.marked_line",
    parameters=model.MarkedLine,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    compiled=False,
    terms=model.terms,
    assumptions=(
        "An instant's image without motion blur; a pinhole with one radial term; discs that face along east as "
        "markers, a line of constant diameter lit from above, no shadows; the line moves near a plane of constant east."
    ),
)
