"""What a host must share with the conductor for its numbers to be the same, and in words where it does not."""

from __future__ import annotations

import functools
import hashlib
import math
import platform
import struct
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version

import numpy as np

from components import cache

Facts = Mapping[str, str]
OPENCV = "opencv-python-headless"
MUST_AGREE = ("towline", "sources", "numba", "llvmlite", "numpy", OPENCV)
LIBM = "libm"
_ARGUMENTS = tuple(0.1 + 0.737 * i for i in range(64))  # spread over some periods, and no power of two among them
_FUNCTIONS = ("sin", "cos", "tan", "exp", "expm1", "log", "log1p", "sinh", "cosh", "tanh", "asinh", "atan", "cbrt")


@functools.cache
def own() -> Facts:
    """Of this process."""
    packages = {name: _version(name) for name in ("towline", "numba", "llvmlite", "numpy", OPENCV)}
    here = {"python": platform.python_version(), "machine": platform.machine(), "node": platform.node()}
    return {**packages, "sources": cache.source_hash()[:16], LIBM: libm_probe(), **here}


def refusal_of_edits(name: str) -> list[str]:
    """What keeps this process out where its sources were edited since own() took note of them: it may hold both."""
    then, now = own()["sources"], cache.source_hash.__wrapped__()[:16]
    return [] if then == now else [f"sources: {then} when {name} was started, {now} now; start it again"]


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def libm_probe() -> str:
    """Hash of the bits that this machine's libm and NumPy give for some arguments."""
    values = [getattr(math, name)(x) for name in _FUNCTIONS for x in _ARGUMENTS]
    values += [math.pow(x, y) for x in _ARGUMENTS[:8] for y in _ARGUMENTS[:8]]
    values += [math.atan2(x, y) for x in _ARGUMENTS[:8] for y in _ARGUMENTS[:8]]
    arguments = np.array(_ARGUMENTS)
    arrays = [np.sin(arguments), np.cos(arguments), np.exp(arguments), np.log(arguments)]
    bits = struct.pack(f"<{len(values)}d", *values) + b"".join(array.tobytes() for array in arrays)
    return hashlib.sha256(bits).hexdigest()[:16]


def refusals(conductor: Facts, host: Facts, name: str) -> list[str]:
    """What keeps the host out of the run, both sides named."""
    return [
        f"{key}: {conductor.get(key, 'unknown')} at the conductor, {host.get(key, 'unknown')} at {name}"
        for key in MUST_AGREE
        if conductor.get(key) != host.get(key)
    ]


def warning(conductor: Facts, host: Facts, name: str) -> str | None:
    """Said where the host's mathematical functions give other bits."""
    if conductor.get(LIBM) == host.get(LIBM):
        return None
    sides = f"{conductor.get(LIBM)} at the conductor, {host.get(LIBM)} at {name}"
    return f"{name}: its libm or NumPy rounds otherwise ({sides}): the digest may differ from a run on one machine"
