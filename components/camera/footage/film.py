"""Frames of a film by number: the images of a folder in the order of their names, or a video file."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import cast

import cv2
import numpy as np

# What is wrong with a film is told once, by FilmError.
cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm")


class FilmError(Exception):
    """What is wrong with a film, in one line."""


class Folder:
    """Images in a folder, in the order of their names; count: how many."""

    def __init__(self, path: Path):
        """Raises FilmError if it holds no image."""
        self._files = sorted(file for file in path.iterdir() if file.suffix.lower() in SUFFIXES)
        self.count = len(self._files)
        if not self._files:
            raise FilmError(f"{path} holds no image ({', '.join(SUFFIXES)})")

    def frame(self, k: int) -> np.ndarray | None:
        """Image k in grey, None beyond the last. Raises FilmError."""
        if k >= self.count:
            return None
        image = cv2.imread(str(self._files[k]), cv2.IMREAD_GRAYSCALE)
        if image is None:
            raise FilmError(f"{self._files[k]} cannot be read as an image")
        return image

    def last(self) -> tuple[int, np.ndarray]:
        """Number and image of the last frame."""
        return self.count - 1, cast(np.ndarray, self.frame(self.count - 1))


class Video:
    """A video file, decoded from its beginning on: seeking is not exact in all formats.

    count: of its frames, once one beyond them was asked for.
    """

    def __init__(self, path: Path):
        """Raises FilmError if it cannot be decoded."""
        self._path, self.count = path, 0
        self._held: tuple[int, np.ndarray] | None = None
        self._open()

    def _open(self) -> None:
        self._capture, self._next = cv2.VideoCapture(str(self._path)), 0
        if not self._capture.isOpened():
            raise FilmError(f"{self._path} cannot be read as a video")

    def frame(self, k: int) -> np.ndarray | None:
        """Frame k in grey, None beyond the last. Raises FilmError."""
        if self._held is None or self._held[0] != k:
            image = None if self.count and k >= self.count else self._decoded(k)
            if image is None:
                return None
            self._held = k, image
        return self._held[1]

    def last(self) -> tuple[int, np.ndarray]:
        """Number and image of the last frame, once one beyond it was asked for."""
        return self.count - 1, cast(np.ndarray, self.frame(self.count - 1))

    def _decoded(self, k: int) -> np.ndarray | None:
        if k < self._next:
            self._open()
        while self._next < k and self._capture.grab():
            self._next += 1
        good, image = self._capture.read() if self._next == k else (False, None)
        if not good or image is None:
            self.count = self._next
            if self.count == 0:
                raise FilmError(f"{self._path} holds no frame that can be decoded")
            return None
        self._next += 1
        return image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)


@lru_cache(maxsize=4)
def open_film(path: str) -> Folder | Video:
    """The film at a path. Raises FilmError if there is none."""
    place = Path(path)
    if place.is_dir():
        return Folder(place)
    if not place.is_file():
        raise FilmError(f"there is no film {path}: expected a folder of images or a video file")
    return Video(place)
