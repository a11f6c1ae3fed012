"""Memory stays flat: an hour of the pool scene, recorded and summed up, below 500 MB resident."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
LIMIT_MB = 500


def peak_mb(*words: str) -> float:
    """Greatest resident memory of a command that must succeed."""
    process = subprocess.Popen([sys.executable, "-m", "pipeline.cli", *words], cwd=ROOT, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0
    return usage.ru_maxrss / 1024


def test_one_hour(tmp_path):
    """Compiling, which takes memory of its own once, is done by a short run before."""
    run = ("run", "scenarios/pool_chain.yaml", "--out", str(tmp_path / "hour.mcap"))
    peak_mb(*run, "--until", "2s")
    assert peak_mb(*run, "--overwrite", "--until", "3600s") < LIMIT_MB
    assert (tmp_path / "hour.mcap").stat().st_size > 100e6, "it was not recorded"
