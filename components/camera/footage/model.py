"""A film that is shown again: parameters and ports."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from components.contract import ImagePort, Parameters, Port, choice, quantity

ENDS = ("stop", "hold")
MISSING = ("stop", "black")


class Footage(Parameters):
    """Images in a folder, by the numbers in their names, or a video file; in grey."""

    film: Path = choice("folder of images, or video file; relative to the file that names it")
    width: Annotated[int, Field(ge=1)] = choice("columns of its images")
    height: Annotated[int, Field(ge=1)] = choice("rows of its images")
    rate: float = quantity("Hz", "images per second at which it was taken", gt=0)
    start: float = quantity("s", "time within the film that is shown at t0", 0.0, ge=0)
    at_end: Literal["stop", "hold"] = choice(
        "whether the run stops where the film ends, or its last image stays", "stop"
    )
    missing: Literal["stop", "black"] = choice(
        "whether the run stops where an image is lost or damaged, or goes on with a black one", "stop"
    )

    def vector(self) -> np.ndarray:
        """Width, height, rate, start, what to do at the end and where an image is missing, and the path's bytes."""
        numbers = [self.width, self.height, self.rate, self.start, ENDS.index(self.at_end), MISSING.index(self.missing)]
        return np.array([*numbers, *str(self.film).encode()], np.float64)


def outputs(footage: Footage) -> tuple[Port, ...]:
    """The image that was the last one at the end of the step."""
    return (
        Port("number", "1", (), "", "of the image within the film, from 0"),
        Port("valid", "1", (), "", "0 where the film lacks this image: it is black then"),
        ImagePort("image", shape=(footage.height, footage.width)),
    )
