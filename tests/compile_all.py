"""Compiles what the tests run, side by side: two workers of pytest would compile much of it twice, at the same time."""

import subprocess
import sys
import tempfile
from pathlib import Path

import yaml

from pipeline import catalogue, compilation

ROOT = Path(__file__).parents[1]
LIMIT_S = 300.0


def before_a_camera(folder: Path) -> Path:
    """The riser before its camera, without the estimators, which would be compiled here and as models too."""
    scene = yaml.safe_load((ROOT / "scenarios" / "riser_tank.yaml").read_text())
    parts = scene["components"].items()
    scene["components"] = {name: one for name, one in parts if not one["model"].startswith("estimator.")}
    (folder / "parameters").symlink_to(ROOT / "scenarios" / "parameters")
    path = folder / "camera.yaml"
    path.write_text(yaml.safe_dump(scene))
    return path


def main() -> None:
    """Models, and what has kernels beside them: the fits of a catenary, camera and vision with the loop."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        run = ["run", str(before_a_camera(folder)), "--until", "70ms", "--out", str(folder / "any.mcap")]
        others = [
            subprocess.Popen(
                [sys.executable, "-m", "pipeline.cli", *words, "--json"], cwd=ROOT, stdout=subprocess.DEVNULL
            )
            for words in (["validity", "logs/sample.mcap"], run)
        ]
        compilation.compile_side_by_side(catalogue.models())
        for other in others:
            other.wait(LIMIT_S)


if __name__ == "__main__":
    main()
