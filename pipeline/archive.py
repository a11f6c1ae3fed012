"""Zip archives of anyone's: their members checked, read, and extracted into a private folder that goes away again."""

from __future__ import annotations

import fcntl
import lzma
import os
import shutil
import stat
import struct
import tempfile
import time
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath

from pipeline.errors import TowlineError

MOST_MEMBERS = 50_000  # the largest FMUs known bring an interpreter with its packages, some 10 000 files
LARGEST = 8_000_000_000  # bytes of all members, extracted
UNSUSPECTED = 200_000_000  # bytes up to which nobody asks how well they were compressed
RATIO = 100  # beyond that: a table of numbers shrinks to a tenth, of zeros to a thousandth
DEEPEST = 32  # folders in folders
LONGEST = 255  # bytes of a name, which file systems take
PREFIX = "towline-extracted-"
SWEPT_AFTER_S = 60.0  # a folder is locked microseconds after it was made
_CHUNK = 1 << 20
_ENCRYPTED = 0x1
_UNIX = 3  # the system whose modes the upper half of external_attr holds
_SPOILT = (
    zipfile.BadZipFile,
    zlib.error,
    lzma.LZMAError,
    EOFError,
    NotImplementedError,
    RuntimeError,
    ValueError,
    struct.error,
)


def members(path: Path, kind: str) -> dict[str, int]:
    """Sizes of the archive's files by name. kind: what it should be, "FMU". Raises TowlineError where it is unsafe."""
    with _opened(path, kind) as (_, files):
        return {about.filename: about.file_size for about in files}


def read(path: Path, kind: str, name: str, largest: int) -> bytes:
    """One file of the archive, of at most `largest` bytes. Raises TowlineError, also where there is no such file."""
    with _opened(path, kind) as (archive, files):
        about = next((about for about in files if about.filename == name), None)
        if about is None:
            raise TowlineError(f"{path}: no {kind}: it has no {name}")
        if about.file_size > largest:
            raise TowlineError(f"{path}: its {name} claims {about.file_size / 1e6:.0f} MB; it is not read")
        return archive.read(about)


@contextmanager
def extracted(path: Path, kind: str) -> Iterator[Path]:
    """The archive's files in a private folder, for as long as the context lasts.

    The folder is locked: what a process leaves that was killed is removed by the next one. Raises TowlineError.
    """
    _sweep()
    folder = Path(tempfile.mkdtemp(prefix=PREFIX))
    lock = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX)
        with _opened(path, kind) as (archive, files):
            try:
                for about in files:
                    _write(archive, about, folder)
            except OSError as error:
                text = error.strerror or str(error)
                raise TowlineError(f"{path}: cannot be extracted into {folder}: {text}") from error
        yield folder
    finally:
        _remove(folder)
        os.close(lock)


@contextmanager
def _opened(path: Path, kind: str) -> Iterator[tuple[zipfile.ZipFile, list[zipfile.ZipInfo]]]:
    """The archive and its files, checked; whatever is wrong with it becomes one line."""
    try:
        if not stat.S_ISREG(path.stat().st_mode):
            raise TowlineError(f"{path}: no file; expected an {kind}, which is a zip archive")
        with zipfile.ZipFile(path) as archive:
            yield archive, _checked(path, archive.infolist())
    except OSError as error:
        raise TowlineError(f"{path}: cannot be read: {error.strerror or error}") from error
    except _SPOILT as error:
        raise TowlineError(f"{path}: no {kind}, or a damaged one: {str(error) or type(error).__name__}") from error


def _checked(path: Path, found: list[zipfile.ZipInfo]) -> list[zipfile.ZipInfo]:
    """The files among the members. Raises TowlineError at the first that is not to be extracted."""
    if len(found) > MOST_MEMBERS:
        raise TowlineError(f"{path}: {len(found)} members; at most {MOST_MEMBERS} are extracted")
    places: dict[PurePosixPath, bool] = {}
    for about in found:
        fault = _fault(about) or _clash(about, places)
        if fault:
            raise TowlineError(f"{path}: its member {about.orig_filename[:200]!r} {fault}; it is not extracted")
    total, packed = sum(about.file_size for about in found), sum(about.compress_size for about in found)
    size = path.stat().st_size
    if packed > size:
        raise TowlineError(f"{path}: its members overlap, as a zip bomb's do; it is not extracted")
    if total > LARGEST or total > max(UNSUSPECTED, RATIO * size):
        claim = f"{size / 1e6:.3g} MB that claim to hold {total / 1e6:.3g} MB"
        limits = f"{LARGEST / 1e9:g} GB, and {RATIO} times its size above {UNSUSPECTED / 1e6:g} MB"
        raise TowlineError(f"{path}: {claim}, as a zip bomb does; at most {limits} are extracted")
    return [about for about in found if not about.is_dir()]


def _fault(about: zipfile.ZipInfo) -> str:
    """What is wrong with a member; nothing: ""."""
    name, parts = about.orig_filename, PurePosixPath(about.orig_filename).parts
    if name.startswith("/") or ".." in parts or "\\" in name or "\0" in name or name[1:2] == ":":
        return "leads out of the archive's folder"
    if not parts or len(parts) > DEEPEST or any(len(os.fsencode(part)) > LONGEST for part in parts):
        return f"has no name that a file can have, of {LONGEST} bytes in {DEEPEST} folders"
    kind = stat.S_IFMT(about.external_attr >> 16) if about.create_system == _UNIX else 0
    if kind not in (0, stat.S_IFREG, stat.S_IFDIR):
        return "is a link or a device, not a file"
    return "is encrypted" if about.flag_bits & _ENCRYPTED else ""


def _clash(about: zipfile.ZipInfo, places: dict[PurePosixPath, bool]) -> str:
    """Whether a member stands where another one does already; places: whether a folder is there, filled in."""
    place = PurePosixPath(about.filename)
    if place in places and not (places[place] and about.is_dir()):
        return "is there twice"
    for folder in place.parents:
        if not places.setdefault(folder, True):
            return "is in a folder that is a file"
    places[place] = about.is_dir()
    return ""


def _write(archive: zipfile.ZipFile, about: zipfile.ZipInfo, folder: Path) -> None:
    """Extract one file, no more of it than it claims."""
    target = folder / about.filename
    target.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    left = about.file_size
    with archive.open(about) as source, target.open("xb") as out:
        while chunk := source.read(_CHUNK):
            left -= len(chunk)
            if left < 0:
                raise zipfile.BadZipFile(f"{about.filename} is larger than it claims")
            out.write(chunk)
    if left:
        raise zipfile.BadZipFile(f"{about.filename} is shorter than it claims")


def _remove(folder: Path) -> None:
    """Remove the folder, also where its contents took away the right to."""
    shutil.rmtree(folder, ignore_errors=True)
    if folder.exists():
        for place, _, _ in os.walk(folder):
            os.chmod(place, 0o700)
        shutil.rmtree(folder, ignore_errors=True)


def _sweep() -> None:
    """Remove folders whose processes died: those of this user that nobody holds locked."""
    for folder in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        try:
            about = folder.lstat()
            if not stat.S_ISDIR(about.st_mode) or about.st_uid != os.getuid():
                continue
            if time.time() - about.st_mtime < SWEPT_AFTER_S:
                continue
            lock = os.open(folder, os.O_RDONLY | os.O_NOFOLLOW)
        except OSError:  # gone meanwhile
            continue
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            _remove(folder)
        except OSError:  # its process lives
            pass
        finally:
            os.close(lock)
