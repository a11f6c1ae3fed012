"""The folder of compiled code: named by a hash of all that it depends on, so that nothing stale is ever run.

It can be found without importing numba, which takes longer than loading the code.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import sys
import tempfile
from functools import cache
from importlib.metadata import version
from pathlib import Path

import llvmlite
import llvmlite.binding

SOURCES = Path(__file__).parent


@cache
def source_hash() -> str:
    """SHA-256 over names and contents of all files of components/, and of those in pipeline/ that compile something."""
    digest = hashlib.sha256()
    for path in sorted([*SOURCES.rglob("*.py"), *(SOURCES.parent / "pipeline").rglob("*.py")]):
        text = path.read_bytes()
        if path.is_relative_to(SOURCES) or b"njit" in text or b"import kernel" in text:
            digest.update(str(path.relative_to(SOURCES.parent)).encode() + b"\0" + text + b"\0")
    return digest.hexdigest()


@cache
def cache_folder() -> Path:
    """The folder of these sources, compilers and CPU: below TOWLINE_CACHE, ~/.cache or the temporary folder."""
    cpu = llvmlite.binding.get_host_cpu_name() + llvmlite.binding.get_host_cpu_features().flatten()
    versions = f"{sys.version_info[:2]} {version('numba')} {llvmlite.__version__} {cpu} {source_hash()}"
    name = hashlib.sha256(versions.encode()).hexdigest()[:16]
    home = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    shared = Path(tempfile.gettempdir()) / f"towline-{os.getuid()}"
    for root in filter(None, (os.environ.get("TOWLINE_CACHE"), Path(home) / "towline", shared)):
        folder = Path(root) / name
        try:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            # What lies in the cache is executed: it must be this user's own.
            if os.access(folder, os.W_OK) and folder.stat().st_uid == os.getuid():
                return folder
        except OSError:
            continue
    return Path(tempfile.mkdtemp(prefix="towline-"))


def clear_cache() -> None:
    """Remove all machine code of these sources, after a part of it was found damaged."""
    for path in cache_folder().iterdir():
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)


def is_marked(name: str) -> bool:
    """Whether compiled functions that are no component's are in the cache, as mark_cached told."""
    return (cache_folder() / f"{name}.done").exists()


def mark_cached(name: str) -> None:
    """Note that they are in the cache now."""
    (cache_folder() / f"{name}.done").touch()
