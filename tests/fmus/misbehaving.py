"""Scenes with one FMU, `bad`, that misbehaves: written, run, and what is left of them looked at."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
from foreign import MODES, PLACES

from pipeline.cli import main
from pipeline.log.reader import open_log

STEPS = 20


def scenario(fmu: Path, parameters: str = "", more: str = "", step: str = "50 ms", beside: str = "") -> None:
    shutil.copyfile(fmu, "bad.fmu")
    Path("s.mcap").unlink(missing_ok=True)
    Path("s.yaml").write_text(
        f"duration: 1 s\nstep: {step}\ncomponents:\n{beside}"
        f"  bad: {{fmu: bad.fmu, parameters: {{{parameters}}}{more}}}\n"
    )


def behaviour(mode: str, where: str = "step", at: float = 0.5) -> str:
    return f"mode: {MODES.index(mode)}, where: {PLACES.index(where)}, at: {at} s"


def refusal(capsys) -> str:
    """The one line with which a run fails."""
    code = main(["run", "s.yaml", "--out", "s.mcap"])
    told = capsys.readouterr()
    lines = [line for line in told.err.splitlines() if not line.startswith("compiling ")]  # said on a cold cache
    assert code == 1, told.err
    assert len(lines) == 1, told.err
    assert lines[0].startswith("towline: ")
    assert told.out == ""
    return lines[0]


def logged(steps: int) -> None:
    """The log is whole up to the step that failed, and tells what ended the run."""
    log = open_log(Path("s.mcap"))
    assert log.complete
    if steps <= STEPS:
        assert "s.mcap holds a run that ended early (bad stopped the run at t = " in log.warning
    y = np.ravel(log.port("bad", "y"))
    assert y.size == steps
    assert np.abs(y - 0.05 * np.arange(steps)).max(initial=0.0) < 1e-12


def replaced(old: str, new: str, count: int = 1):
    return lambda text: text.replace(old, new, count)
