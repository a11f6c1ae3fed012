"""FMUs of components of other scenarios, built on first use and kept in the cache."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

from components.cache import cache_folder
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
    if not path.exists():
        from pipeline.fmu.build import build  # with numba

        archive = build(found, FMI)
        path.parent.mkdir(exist_ok=True)
        fresh = path.with_suffix(f".{os.getpid()}.tmp")
        fresh.write_bytes(archive)
        fresh.replace(path)
    return path


def _key(found: Instance) -> str:
    """A hash of all that the FMU is made of beside the sources, by which the cache's folder is named."""
    p = found.component.pack(found.parameters, found.seed)
    told = f"{found.component.name} {found.parameters!r} {found.seed} {found.step_ns} {found.start_ns} {found.inputs}"
    return hashlib.sha256(told.encode() + p.tobytes() + _own_source(found)).hexdigest()[:16]


def _own_source(found: Instance) -> bytes:
    """The file of a component of the user's own, which no source hash knows."""
    return Path(found.component.step.__code__.co_filename).read_bytes()
