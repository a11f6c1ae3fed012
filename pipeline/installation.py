"""What is wrong with the Python environment or the disk that Towline stands on, in one line with what mends it."""

from __future__ import annotations

import errno
import shlex
import sys
from importlib.metadata import PackageNotFoundError
from pathlib import Path

ROOT = Path(__file__).parents[1]
OWN = ("components", "pipeline")
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS)


def told(error: BaseException) -> str | None:
    """The line on an error that is none of Towline's own; None for any other."""
    if isinstance(error, ImportError):
        name = (error.name or "").partition(".")[0]
        absent = isinstance(error, PackageNotFoundError | ModuleNotFoundError)
        return None if not name or name in OWN else _package(name, "is not installed" if absent else "does not fit")
    if isinstance(error, OSError) and error.errno in FULL:
        return _disk(error)
    return None


def _package(name: str, what: str) -> str:
    if not (ROOT / "pyproject.toml").exists():  # not an editable installation
        return f"the package {name} {what} in {sys.prefix}: install Towline anew there"
    install = shlex.join([sys.executable, "-m", "pip", "install", "-e", str(ROOT)])
    return (
        f"the package {name} {what} in {sys.prefix}: this environment is older than the sources in {ROOT}, or not "
        f"made for them; run `make` there, or {install}"
    )


def _disk(error: OSError) -> str:
    from components.cache import cache_folder

    what = f"{error.filename}: {error.strerror}" if error.filename else f"{error.strerror}"
    return f"{what}; compiled code is kept in {cache_folder()}: make room there, or set TOWLINE_CACHE to another folder"
