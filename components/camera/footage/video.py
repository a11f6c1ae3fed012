"""Frames of a video file by the times that they have in it, so that a lost one does not shift those behind it.

A frame of which a part is damaged comes as its decoder fills it up; FFmpeg tells so on standard error, OpenCV not.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from components.camera.footage.faults import FilmError, MissingImage

# What is wrong with a film is told once, by FilmError.
cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
PACKETS = (cv2.CAP_PROP_FORMAT, -1)  # as they are in the file, not decoded
RIFF = b"RIFF"  # how an AVI begins
ROUNDED = 1  # frames by which a container's length may be rounded up


class Video:
    """A video file, decoded from its beginning on: seeking is not exact in all formats.

    count: of its frames, those that are missing included.
    """

    def __init__(self, path: Path):
        """Raises FilmError if it cannot be decoded, or frames are missing and it does not tell which."""
        self._path = path
        self._shift, self._there, self.count = _listed(path)
        self._held: tuple[int, np.ndarray] | None = None
        self._ahead: int | None = None
        self._open()

    def _open(self) -> None:
        self._capture, self._ahead, self._last = _capture(self._path), None, -1

    def frame(self, k: int) -> np.ndarray:
        """Frame k < count in grey. Raises MissingImage."""
        if self._held is None or self._held[0] != k:
            if k not in self._there:
                raise self._missing(k, "is missing")
            self._held = k, self._decoded(k)
        return self._held[1]

    def _missing(self, k: int, what: str) -> MissingImage:
        lost = self.count - len(self._there)
        return MissingImage(
            f"frame {k} of {self._path} {what} ({lost} of {self.count} frames lost): copy the video again, or set "
            "missing to black"
        )

    def _decoded(self, k: int) -> np.ndarray:
        """Frame k, which comes before others have: what was decoded beyond it stays grabbed."""
        if k <= self._last:
            self._open()
        tries = self.count - self._last  # one a frame: it goes on behind a frame that it cannot decode
        while tries > 0 and (self._ahead is None or self._ahead < k):
            tries -= 1
            if self._capture.grab():
                self._ahead = int(self._capture.get(cv2.CAP_PROP_PTS)) - self._shift
        if self._ahead is None or self._ahead < k:
            self._ahead = self.count
        if self._ahead > k:
            self._there = self._there - {k}
            raise self._missing(k, "cannot be decoded")
        good, image = self._capture.retrieve()
        self._last, self._ahead = k, None
        if not good or image is None:
            raise self._missing(k, "cannot be decoded")
        return image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)


def _capture(path: Path, *options: int) -> cv2.VideoCapture:
    """Raises FilmError."""
    capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG, list(options))
    if not capture.isOpened():
        raise FilmError(f"{path} cannot be read as a video: copy it again if it was cut short, or save its images")
    return capture


def _listed(path: Path) -> tuple[int, frozenset[int], int]:
    """The time of frame 0 in frames, the numbers of the frames that are there, and how many there were.

    From the container alone, without decoding. Raises FilmError.
    """
    packets = _capture(path, *PACKETS)
    told, times = int(packets.get(cv2.CAP_PROP_FRAME_COUNT)), []
    while packets.grab():
        times.append(int(packets.get(cv2.CAP_PROP_PTS)))
    if not times:
        raise FilmError(f"{path} holds no frame that can be decoded")
    times.sort()
    with path.open("rb") as stream:
        is_avi = stream.read(len(RIFF)) == RIFF
    if is_avi and times[-1] + 1 < told:
        raise FilmError(
            f"{path} holds {len(times)} of the {told} frames that its header tells, and an AVI does not tell which are "
            "missing: copy it again, or save as images what is good of it"
        )
    shift = 0 if times[-1] < told else times[0]
    there = frozenset(time - shift for time in times)
    if len(there) < len(times):
        raise FilmError(f"{path} has frames that are not equally spaced in time: convert it to a constant frame rate")
    last = times[-1] - shift
    return shift, there, last + 1 if told - last - 1 <= ROUNDED else told
