"""Ctrl-C at moments that are hard to hit from outside. Authority: what the README says of it."""

from __future__ import annotations

import ctypes
import json
import os
import signal
from pathlib import Path

import pytest

from pipeline import interrupts
from pipeline.cli import main
from pipeline.log.reader import open_log
from pipeline.log.recorder import Recorder

RING = Path(__file__).parents[2] / "scenarios" / "van_der_pol.yaml"


@pytest.fixture(autouse=True)
def handlers():
    """As they were before."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def interrupt(*_: object) -> int:
    os.kill(os.getpid(), signal.SIGINT)
    return 0


def test_while_a_command_is_imported(monkeypatch, capsys):
    monkeypatch.setattr("pipeline.cli.importlib.import_module", interrupt)
    assert main(["run", "a.yaml", "--json"]) == 130
    out, err = capsys.readouterr()
    assert (json.loads(out), err) == ({"error": "interrupted"}, "towline: interrupted\n")


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_within_a_callback_from_compiled_code():
    """As the compiler's: the exception is printed and dropped, and the run would go on."""
    interrupts.begin()
    ctypes.CFUNCTYPE(ctypes.c_int)(interrupt)()
    with pytest.raises(KeyboardInterrupt):
        interrupts.raise_if_lost()


def test_while_the_log_is_closed(tmp_path, monkeypatch):
    """The first time it is closed all the same."""
    close = Recorder.close
    monkeypatch.setattr(Recorder, "close", lambda self: (interrupt(), close(self)))
    path = tmp_path / "a.mcap"
    assert main(["run", str(RING), "--until", "10 ms", "--out", str(path), "--json"]) == 0
    log = open_log(path)
    assert log.complete
    assert log.metadata("result")["ending"] == "complete"
