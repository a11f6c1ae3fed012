"""The local socket of a run: in a folder that only its user can enter, removed with the run or by a later one."""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path

_PREFIX = "towline-bus-"


class LocalSocket:
    """A folder for one socket; `endpoint` is zenoh's name of it."""

    def __init__(self) -> None:
        _sweep()
        self._folder = tempfile.mkdtemp(prefix=f"{_PREFIX}{os.getpid()}-")
        self.endpoint = f"unixsock-stream/{self._folder}/bus"

    def remove(self) -> None:
        """Remove folder and socket."""
        shutil.rmtree(self._folder, ignore_errors=True)


def _sweep() -> None:
    """Remove what this user's killed conductors left."""
    for folder in Path(tempfile.gettempdir()).glob(f"{_PREFIX}*-*"):
        number = folder.name.removeprefix(_PREFIX).partition("-")[0]
        try:
            if folder.stat().st_uid == os.getuid() and number.isdigit() and not Path(f"/proc/{number}").exists():
                shutil.rmtree(folder, ignore_errors=True)
        except OSError:  # another has removed it
            continue
