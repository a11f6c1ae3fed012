"""Synthetic lines and the pool scenes' logs for the tests of the analysis."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import psutil
import pytest
from foreign import ALL_KINDS, ARRAYS, BALL, KINDS, VAN_DER_POL, ForeignFmus
from scipy.optimize import brentq

from pipeline.cli import main
from pipeline.log.reader import Log, open_log

ROOT = Path(__file__).parents[2]
EXACT = np.longdouble  # 64 bits of mantissa on x86: the generator's own rounding stays below the last bit of float64


def hanging_line(
    C: float = 1.0,
    length: float = 2.695,
    chord: float = 0.0,
    markers: int = 12,
    alpha: float = 0.0,
    psi: float = 0.0,
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> np.ndarray:
    """Markers evenly along an inclined catenary, NED [m]: Drupt et al. 2022, eq. 2, 6-8, in extended precision.

    chord: angle of the ends' chord to x_p in the plane [rad]. psi: heading of x_p. C < 0: a buoyant line.
    """
    reach = abs(C) * length

    def middle(half: float) -> float:
        return float(np.arccosh(max(1.0, reach / (2.0 * np.sinh(half)))))

    widest = float(np.arcsinh(0.5 * reach))
    half = widest
    if chord:
        half = brentq(
            lambda y: np.sinh(middle(y)) * np.sinh(y) / y - np.tan(chord),
            1e-9 * widest,
            widest,
            xtol=1e-300,
            rtol=1e-15,
        )
    first, last = EXACT(middle(half) - half), EXACT(middle(half) + half)
    arc = np.sinh(first) + (np.sinh(last) - np.sinh(first)) * np.linspace(EXACT(0), EXACT(1), markers)
    X = np.arcsinh(arc)
    x = (X - X[markers // 2]) / EXACT(abs(C))
    z = (np.cosh(X) - np.cosh(X[markers // 2])) / EXACT(C)
    along = np.array([np.cos(EXACT(psi)), np.sin(EXACT(psi)), EXACT(0)])
    sine, cosine = np.sin(EXACT(alpha)), np.cos(EXACT(alpha))
    up_the_plane = np.array([-sine * along[1], sine * along[0], -cosine])
    return (x[:, None] * along + z[:, None] * up_the_plane + np.array(origin, EXACT)).astype(np.float64)


@pytest.fixture(scope="session")
def line() -> Callable[..., np.ndarray]:
    """The generator above."""
    return hanging_line


@pytest.fixture(scope="session")
def pool_logs(tmp_path_factory) -> dict[str, Path]:
    """Logs of both pool scenes, whole, by name."""
    folder = tmp_path_factory.mktemp("pools")
    logs = {name: folder / f"{name}.mcap" for name in ("pool_chain", "pool_rope")}
    for name, path in logs.items():
        assert main(["run", str(ROOT / "scenarios" / f"{name}.yaml"), "--out", str(path), "--json"]) == 0
    return logs


@pytest.fixture(scope="session")
def fmu_of(tmp_path_factory) -> Callable[..., Path]:
    """A function that gives the FMU of `scenario.yaml#component`, or of a model with parameters, built once."""
    from pipeline.fmu.build import build
    from pipeline.fmu.instance import instance

    folder, made = tmp_path_factory.mktemp("fmus"), {}

    def fmu(text: str, fmi: int = 2, *overrides: str) -> Path:
        key = (text, fmi, overrides)
        if key not in made:
            path = str(ROOT / "scenarios" / text) if "#" in text else text
            of = instance(path, overrides)
            made[key] = folder / f"{of.component.name}_{len(made)}_{fmi}.fmu"
            made[key].write_bytes(build(of, fmi))
        return made[key]

    return fmu


@pytest.fixture(scope="session")
def foreign(tmp_path_factory) -> ForeignFmus:
    """Builds the FMUs of tests/fmus."""
    return ForeignFmus(tmp_path_factory.mktemp("foreign"))


@pytest.fixture(scope="session")
def fmus(foreign, tmp_path_factory) -> Path:
    """A folder of FMUs."""
    folder = tmp_path_factory.mktemp("system")
    for name, model, fmi in (
        ("vdp", VAN_DER_POL, 2),
        ("kinds", KINDS, 2),
        ("arrays", ARRAYS, 2),
        ("ball", BALL, 2),
        ("arrays3", ARRAYS, 3),
        ("kinds3", ALL_KINDS, 3),
    ):
        (folder / f"{name}.fmu").write_bytes(foreign(model, fmi).read_bytes())
    return folder


@pytest.fixture
def place(fmus, tmp_path, monkeypatch) -> Path:
    """A folder of the test's own with the FMUs in it."""
    for path in fmus.iterdir():
        (tmp_path / path.name).symlink_to(path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


class SceneRunner:
    """Runs scenarios written as text and keeps what they said."""

    def __init__(self, folder: Path, capsys):
        self.folder, self.capsys = folder, capsys
        self.said, self.result = "", {}

    def __call__(
        self, components: str, *options: str, until: str = "1 s", top: str = "", status: int = 0
    ) -> Log | None:
        """The log. components: YAML, as lines of the mapping."""
        lines = "\n".join(f"  {line}" for line in components.strip().splitlines())
        text = f"duration: {until}\nstep: 10 ms\nscene: false\ncomponents:\n{lines}\n{top}"
        (self.folder / "scene.yaml").write_text(text)
        log = self.folder / "run.mcap"
        words = ["run", str(self.folder / "scene.yaml"), "--out", str(log), "--overwrite", "--json", *options]
        assert main(words) == status
        out, self.said = self.capsys.readouterr()
        self.result = json.loads(out)
        return open_log(log) if log.exists() else None

    def output(self) -> str:
        """What has been written to standard output since the last run."""
        return self.capsys.readouterr().out


@pytest.fixture
def run(tmp_path, capsys) -> SceneRunner:
    """Runs scenes."""
    return SceneRunner(tmp_path, capsys)


@pytest.fixture
def clean_place(tmp_path, monkeypatch) -> Iterator[Path]:
    """A folder of the test's own, in which no temporary file is left, nor a process of this one."""
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    monkeypatch.setenv("TMPDIR", str(temporary))
    monkeypatch.chdir(tmp_path)
    before = set(psutil.Process().children(recursive=True))
    yield tmp_path
    left = [
        p for p in psutil.Process().children(recursive=True) if p not in before and p.status() != psutil.STATUS_ZOMBIE
    ]
    assert left == []
    assert list(temporary.iterdir()) == []
