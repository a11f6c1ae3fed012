"""A camera that sees one mark on a ruled wall: an image of the height that it is told."""

from typing import Annotated

import numpy as np
from pydantic import Field

from components.contract import HEADER, Component, ImagePort, Parameters, Port, Sizes, choice, quantity


class Camera(Parameters):
    """Its picture's size, and how it goes wrong."""

    scale: float = quantity("1", "pixels a unit of height", 8.0, tunable=True)
    height: Annotated[int, Field(ge=1)] = choice("pixels", 37)
    width: Annotated[int, Field(ge=1)] = choice("pixels", 51)
    is_color: bool = choice("whether it sees colours", False)


def image(camera: Camera) -> ImagePort:
    channels = (3,) if camera.is_color else ()
    return ImagePort("image", shape=(camera.height, camera.width, *channels), frame="lens")


def step(t_ns, dt_ns, p, u, x, y, w, images_in, images_out):
    scale, height, width, is_color = p[HEADER], *(int(n) for n in p[HEADER + 1 : HEADER + 4])
    x[0] += 1.0
    row = np.arange(height)[:, None]
    wall = (np.arange(width)[None, :] * 7 + row * 3 + int(x[0])) % 200
    mark = np.abs(row - 0.5 * height - scale * u[0]) < 2.5
    grey = np.where(mark, 255, wall).astype(np.uint8)
    images_out["image"] = np.stack([grey, 255 - grey, grey // 2], axis=2) if is_color else grey
    y[0] = t_ns / 1e9
    return 0


COMPONENT = Component(
    name="test.camera",
    parameters=Camera,
    inputs=lambda _: (Port("height", "1"),),
    outputs=lambda camera: (Port("time", "s"), image(camera)),
    sizes=lambda _: Sizes(state=1),
    init=step,
    step=step,
    compiled=False,
)
