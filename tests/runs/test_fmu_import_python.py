"""FMUs that pythonfmu and pythonfmu3 make, whose binaries run Python in the process that loads them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

SCRIPTS = {
    "pythonfmu": """
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class Spring(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.x, self.v, self.k, self.force = 1.0, 0.0, 10.0, 0.0
        for name in ("x", "v"):
            self.register_variable(Real(name, causality=Fmi2Causality.output))
        self.register_variable(Real("k", causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable))
        self.register_variable(Real("force", causality=Fmi2Causality.input))

    def do_step(self, t, h):
        self.v += h * (self.force - self.k * self.x)
        self.x += h * self.v
        return True
""",
    "pythonfmu3": """
from pythonfmu3 import Fmi3Causality, Fmi3Slave, Fmi3Variability, Float64


class Spring(Fmi3Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.time, self.x, self.v, self.k, self.force = 0.0, 1.0, 0.0, 10.0, 0.0
        about = {"causality": Fmi3Causality.independent, "variability": Fmi3Variability.continuous}
        self.register_variable(Float64("time", **about))
        for name in ("x", "v"):
            self.register_variable(Float64(name, causality=Fmi3Causality.output))
        self.register_variable(Float64("k", causality=Fmi3Causality.parameter, variability=Fmi3Variability.tunable))
        self.register_variable(Float64("force", causality=Fmi3Causality.input))

    def do_step(self, t, h):
        self.v += h * (self.force - self.k * self.x)
        self.x += h * self.v
        return True
""",
}


def built(package: str, folder: Path) -> Path:
    pytest.importorskip(package, reason=f"{package} is not installed: pip install 'towline[dev]'")
    script = folder / f"spring_{package}.py"  # in one process their modules share sys.modules
    script.write_text(SCRIPTS[package])
    words = [sys.executable, "-m", package, "build", "-f", str(script), "-d", str(folder)]
    subprocess.run(words, check=True, capture_output=True, timeout=60)
    return folder / "Spring.fmu"


def expected(steps: int) -> np.ndarray:
    """The same arithmetic in Python: x after each step, t0 first; k becomes 30 after half of them."""
    x, v, found = 1.0, 0.0, [1.0]
    for step in range(steps):
        v += 0.01 * (1.0 - (20.0 if step < steps // 2 else 30.0) * x)
        x += 0.01 * v
        found.append(x)
    return np.array(found)


@pytest.mark.parametrize("package", SCRIPTS)
def test_isolated_and_in_this_process(package, run, tmp_path):
    own = "isolate: %s, overdue: 30 s, parameters: {k: 20}, inputs: {force: 1}"
    a = f"a: {{fmu: {built(package, tmp_path)}, {own}}}"
    top = "events: [{at: 500 ms, set: {a.k: 30}}]"
    for isolate in ("true", "false"):
        log = run(a % isolate, top=top)
        assert log.port("a", "x").tolist() == expected(100).tolist()
