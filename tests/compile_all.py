"""Compiles what the tests run, side by side: two workers of pytest would compile much of it twice, at the same time."""

import subprocess
import sys
import tempfile
from pathlib import Path

from pipeline import catalogue, compilation

ROOT = Path(__file__).parents[1]
# What has kernels beside the models': the fits of a catenary, camera and vision with the loop.
COMMANDS = ("validity logs/sample.mcap", "run scenarios/riser_tank.yaml --until 70ms --out {folder}/any.mcap")


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        words = [command.format(folder=folder).split() for command in COMMANDS]
        others = [
            subprocess.Popen(
                [sys.executable, "-m", "pipeline.cli", *one, "--json"], cwd=ROOT, stdout=subprocess.DEVNULL
            )
            for one in words
        ]
        compilation.compile_side_by_side(catalogue.models())
        for other in others:
            other.wait(300)


if __name__ == "__main__":
    main()
