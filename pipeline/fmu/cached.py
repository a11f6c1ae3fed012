"""FMUs of components of other scenarios, built on first use and kept in the cache."""

from __future__ import annotations

import hashlib
import os
from contextlib import suppress
from functools import cache
from pathlib import Path
from zipfile import is_zipfile

from components.cache import SOURCES, cache_folder
from components.contract import Component
from pipeline.errors import TowlineError
from pipeline.fmu.instance import Instance, instance

FMI = 2
_asked: list[str] = []  # references that are being resolved: a scenario that is read may hold others


def cached_fmu(folder: Path, reference: str) -> Path:
    """The FMU of `scenario.yaml#component`, whose path is relative to `folder`.

    Raises TowlineError where it cannot be built, ScenarioError with all problems of that scenario.
    """
    file, _, name = reference.rpartition("#")
    full = f"{(folder / file).resolve()}#{name}"
    if full in _asked:
        raise TowlineError(f"'{reference}' is made of itself: {' -> '.join([*_asked, full])}")
    _asked.append(full)
    try:
        found = instance(full, ())
    finally:
        _asked.pop()
    path = cache_folder() / "fmus" / f"{name}_{_key(found)}.fmu"
    if not is_zipfile(path):  # it is not there, or damaged
        from pipeline.fmu.build import build  # with numba

        _keep(path, build(found, FMI))
    return path


def _keep(path: Path, archive: bytes) -> None:
    """Write an FMU whole or not at all; of several processes at once the last one's stays. Raises TowlineError."""
    fresh = path.with_suffix(f".{os.getpid()}.tmp")
    try:
        path.parent.mkdir(exist_ok=True)
        fresh.write_bytes(archive)
        fresh.replace(path)
    except OSError as error:
        with suppress(OSError):
            fresh.unlink()
        remedy = "mend that, or set TOWLINE_CACHE to a folder to keep compiled code in"
        raise TowlineError(f"{path}: the FMU cannot be kept: {error.strerror}; {remedy}") from error


def _key(found: Instance) -> str:
    """A hash of all that the FMU is made of beside the sources, by which the cache's folder is named."""
    p = found.component.pack(found.parameters, found.seed)
    told = f"{found.component.name} {found.parameters!r} {found.seed} {found.step_ns} {found.start_ns} {found.inputs}"
    return hashlib.sha256(told.encode() + p.tobytes() + _builder() + _own(found.component)).hexdigest()[:16]


@cache
def _builder() -> bytes:
    """The sources of this folder, which the cache's folder is not named by: those in C become a part of every FMU."""
    sources = (path for path in Path(__file__).parent.rglob("*") if path.suffix in (".py", ".c", ".h"))
    return b"".join(path.read_bytes() for path in sorted(sources))


def _own(component: Component) -> bytes:
    """Of a component of the user's own: its files, with those beside it, and the code they make with what they read."""
    files = {Path(function.__code__.co_filename) for function in (component.init, component.step)}
    folders = sorted({file.parent for file in files if not file.is_relative_to(SOURCES)})
    if not folders:
        return b""
    from pipeline.fmu.machine_code import object_code  # with numba

    texts = (path.read_bytes() for folder in folders for path in sorted(folder.glob("*.py")))
    return b"".join(texts) + object_code(component)
