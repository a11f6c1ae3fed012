"""Images of a folder by number: by those in their names, so that a hole among them stays one."""

from __future__ import annotations

import re
from collections import Counter
from itertools import pairwise
from math import gcd
from pathlib import Path

import cv2
import numpy as np

from components.camera.footage.faults import FilmError, MissingImage

SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm")
NUMBERED = re.compile(r"(.*?)(\d+)(\D*)")  # what is before a name's last number, that number, and what follows
# What the last bytes of a whole file hold; decoders fill up what is cut off.
ENDINGS = {".png": b"IEND", ".jpg": b"\xff\xd9", ".jpeg": b"\xff\xd9"}
TAIL = 64  # bytes in which they stand


class Folder:
    """Images in a folder; count: how many it had when none was missing.

    Names that differ in their last number only are counted by it, from the least on, in steps of the greatest one that
    fits all; others are taken in the order of the names.
    """

    def __init__(self, path: Path):
        """Raises FilmError if it holds no image, two of one number, or one that does not fit the others' names."""
        self._path = path
        files = sorted(file for file in path.iterdir() if file.suffix.lower() in SUFFIXES)
        if not files:
            raise FilmError(f"{path} holds no image ({', '.join(SUFFIXES)})")
        numbers = _numbers(files)
        first = min(numbers)
        self._stride = gcd(*(n - first for n in numbers)) or 1
        self._first, self._example = first, files[numbers.index(first)]
        self._files = {(n - first) // self._stride: file for n, file in zip(numbers, files, strict=True)}
        self.count = max(self._files) + 1

    def frame(self, k: int) -> np.ndarray:
        """Image k < count in grey. Raises MissingImage."""
        if k not in self._files:
            lost, number = self.count - len(self._files), self._first + k * self._stride
            raise MissingImage(
                f"image {k} of {self._path}, number {number}, is missing ({lost} of {self.count} lost; the first is "
                f"{self._example.name}): put it back, rename them if their numbers do not count images, or set "
                "missing to black"
            )
        file = self._files[k]
        image = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE) if _is_whole(file) else None
        if image is None:
            raise MissingImage(f"image {k}, {file}, cannot be read as an image: copy it again, or set missing to black")
        return image


def _numbers(files: list[Path]) -> list[int]:
    """Each file's number, or its place where the names are not numbered. Raises FilmError."""
    parts = [NUMBERED.fullmatch(file.stem) for file in files]
    frames = [part and (part[1], part[3]) for part in parts]
    frame, alike = Counter(frames).most_common(1)[0]
    if frame is None or 2 * alike <= len(files):
        return list(range(len(files)))
    if alike < len(files):
        odd = next(i for i, own in enumerate(frames) if own != frame)
        usual = next(i for i, own in enumerate(frames) if own == frame)
        raise FilmError(
            f"{files[odd]} is not numbered as {files[usual].name} and {alike - 1} others are: move it to another folder"
        )
    numbers = [int(part[2]) for part in parts if part]
    order = sorted(range(len(files)), key=numbers.__getitem__)
    for i, j in pairwise(order):
        if numbers[i] == numbers[j]:
            raise FilmError(f"{files[i]} and {files[j].name} have one number: move one to another folder")
    return numbers


def _is_whole(file: Path) -> bool:
    """Whether a file has the ending of its format."""
    ending = ENDINGS.get(file.suffix.lower(), b"")
    with file.open("rb") as stream:
        stream.seek(max(file.stat().st_size - TAIL, 0))
        return ending in stream.read()
