"""Frames of a film by number: the images of a folder, or a video file."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from components.camera.footage.faults import FilmError
from components.camera.footage.folder import Folder
from components.camera.footage.video import Video


@lru_cache(maxsize=4)
def open_film(path: str) -> Folder | Video:
    """The film at a path. Raises FilmError if there is none."""
    place = Path(path)
    if place.is_dir():
        return Folder(place)
    if not place.is_file():
        raise FilmError(f"there is no film {path}: expected a folder of images or a video file")
    return Video(place)
