"""Rerun's viewer as a process of its own: listening on loopback only, its analytics off, with a window or without."""

from __future__ import annotations

import os
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from components.cache import cache_folder
from pipeline.errors import TowlineError
from pipeline.viewing.rerun_file import TIMELINE, rerun_module

LOADED_S = 60.0  # wall time that the viewer may take to start and to load a recording
SETTLED_S = 1.0  # until its windows are laid out and its notices gone
SIZE = "1600x1000"


def show(path: Path) -> None:
    """Open the recording in a window, and return once that is closed. Raises TowlineError."""
    done = subprocess.run([*_command(path, _free_port())], env=_environment(), stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        raise TowlineError(f"Rerun's viewer failed: {_reason(done.stderr)}; --screenshot F.png needs no window")


def screenshot(path: Path, image: Path, at_s: float) -> None:
    """Save what the viewer shows of the recording at a time, without a window. Raises TowlineError."""
    viewer_client = rerun_module("rerun.experimental").ViewerClient
    with _headless(path) as (process, url):
        until = time.monotonic() + LOADED_S
        while True:
            try:
                client = viewer_client.connect(url)
                state = client.get_state()
                if state.recordings and not state.loading:
                    break
            except Exception as error:  # Rerun's are of many kinds; it is not there yet, or never will be
                if process.poll() is not None:
                    told = process.stderr.read() if process.stderr else ""
                    raise TowlineError(f"Rerun's viewer failed: {_reason(told)}") from error
                if time.monotonic() > until:
                    raise TowlineError(f"Rerun's viewer did not load {path} in {LOADED_S:g} s: {error}") from error
            time.sleep(0.2)
        client.set_time(TIMELINE, duration=at_s, play_state="paused")
        time.sleep(SETTLED_S)
        try:
            client.save_screenshot(str(image.absolute()))
        except Exception as error:
            raise TowlineError(f"{image}: Rerun's viewer did not save it: {error}") from error


@contextmanager
def _headless(path: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    port = _free_port()
    command = [*_command(path, port), "--headless", "--window-size", SIZE]
    process = subprocess.Popen(command, env=_environment(), stderr=subprocess.PIPE, text=True)
    try:
        yield process, f"rerun+http://127.0.0.1:{port}/proxy"
    finally:
        process.kill()
        process.communicate()


def _command(path: Path, port: int) -> list[str]:
    package = Path(rerun_module().__file__).parents[1] / "rerun_cli"
    return [str(package / "rerun"), str(path), "--bind", "127.0.0.1", "--port", str(port)]


def _environment() -> dict[str, str]:
    """That of this process, with a folder of settings in which analytics are off; the user's own is left alone."""
    folder = cache_folder().parent / "rerun"
    folder.mkdir(exist_ok=True)
    environment = {**os.environ, "XDG_CONFIG_HOME": str(folder)}
    command = [_command(Path(), 0)[0], "analytics", "disable"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=LOADED_S)
    if done.returncode != 0:
        raise TowlineError(f"Rerun's analytics cannot be turned off: {_reason(done.stderr)}")
    return environment


def _free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def _reason(told: str) -> str:
    """The line of the viewer's output that says most."""
    lines = [line.strip() for line in told.splitlines() if line.strip()]
    marked = [line for line in lines if "rror" in line]
    return (marked or lines or ["it said nothing"])[0][:300]
