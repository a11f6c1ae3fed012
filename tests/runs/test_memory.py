"""Memory stays flat: an hour of the pool scene, recorded and summed up, below 500 MB resident."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
LIMIT_MB = 500
LIMIT_S = 200
# The kernel's own record of this process' memory: ru_maxrss would still hold that of the test process it came from.
CODE = """
import sys
from pipeline.cli import main
assert main(sys.argv[1:]) == 0
print(next(line for line in open("/proc/self/status") if line.startswith("VmHWM")).split()[1])
"""


def peak_mb(*words: str) -> float:
    """Greatest resident memory of a command that must succeed."""
    command = [sys.executable, "-c", CODE, *words]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, timeout=LIMIT_S, check=True)
    return int(done.stdout) / 1024


def test_one_hour(tmp_path):
    """Compiling, which takes memory of its own once, is done by a short run before."""
    run = ("run", "scenarios/pool_chain.yaml", "--out", str(tmp_path / "hour.mcap"))
    peak_mb(*run, "--until", "2s")
    assert peak_mb(*run, "--overwrite", "--until", "3600s") < LIMIT_MB
    assert (tmp_path / "hour.mcap").stat().st_size > 100e6, "it was not recorded"
