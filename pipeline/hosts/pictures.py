"""A Python component's images: what it sees of the loop's vectors, and what it has drawn put into them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from components.contract import ImagePort, Port, placed_images


class ImageError(Exception):
    """An image output that is missing, of another kind, or not declared."""


class Pictures:
    """The images of one component in its u and y. seen: image inputs by name, read-only."""

    def __init__(self, inputs: Sequence[Port], outputs: Sequence[Port], u: np.ndarray, y: np.ndarray):
        self.seen: Mapping[str, np.ndarray] = MappingProxyType(
            {port.name: _read_only(port.in_words(u[span])) for port, span in placed_images(inputs)}
        )
        self._outputs = [(port, y[span].view(np.uint8)) for port, span in placed_images(outputs)]

    @property
    def is_any(self) -> bool:
        """Whether there are images at all."""
        return bool(self.seen or self._outputs)

    def put(self, drawn: Mapping[str, np.ndarray]) -> None:
        """Write all image outputs. Raises ImageError, before any is written."""
        others = drawn.keys() - {port.name for port, _ in self._outputs}
        if others:
            raise ImageError(f"it put an image {sorted(map(str, others))[0]!r} out, and has no such output")
        for port, _ in self._outputs:
            if fault := _fault(port, drawn.get(port.name)):
                raise ImageError(fault)
        for port, target in self._outputs:
            target[: port.pixels].reshape(port.shape)[...] = drawn[port.name]
            target[port.pixels :] = 0


def _fault(port: ImagePort, image: object) -> str:
    expected = f"expected an array of uint8, {port.shape}"
    if image is None:
        return f"its output {port.name} is missing; {expected} in images_out[{port.name!r}], in init and every step"
    if not isinstance(image, np.ndarray):
        return f"its output {port.name} is a {type(image).__name__}; {expected}"
    if image.dtype != np.uint8 or image.shape != port.shape:
        return f"its output {port.name} is an array of {image.dtype}, {image.shape}; {expected}"
    return ""


def _read_only(image: np.ndarray) -> np.ndarray:
    image.flags.writeable = False
    return image
