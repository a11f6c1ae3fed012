"""Keeps standard output for results while FMUs are in this process: what they print goes to standard error."""

from __future__ import annotations

import ctypes
import os
import sys
from contextlib import suppress

_STANDARD_OUTPUT, _STANDARD_ERROR = 1, 2


class _Diversion:
    """users: FMUs in this process. kept: where standard output leads meanwhile; -1: it is not diverted."""

    users = 0
    kept = -1


def divert() -> None:
    """Begin; for each of these there is one restore()."""
    _Diversion.users += 1
    if _Diversion.users > 1:
        return
    with suppress(OSError, ValueError):  # one of the streams is closed
        sys.stdout.flush()
        kept = os.dup(_STANDARD_OUTPUT)
        os.dup2(_STANDARD_ERROR, _STANDARD_OUTPUT)
        _Diversion.kept = kept


def restore() -> None:
    """End: what the FMUs have printed and C still holds is written out first."""
    _Diversion.users -= 1
    if _Diversion.users > 0 or _Diversion.kept < 0:
        return
    ctypes.CDLL(None).fflush(None)
    os.dup2(_Diversion.kept, _STANDARD_OUTPUT)
    os.close(_Diversion.kept)
    _Diversion.kept = -1
