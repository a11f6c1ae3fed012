"""The cache of machine code: never stale, mended where damaged, and sure of whom it was made for."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

MODEL = '''"""A component of a user's own."""

from pathlib import Path

import numpy as np

from components.compiled import kernel
from components.contract import Component, Port

TABLE = np.loadtxt(Path(__file__).parent / "table.txt", ndmin=1)


@kernel
def value():
    return TABLE[0] + {edit}


def step(t_ns, dt_ns, p, u, x, y, w):
    y[0] = value()
    return 0


from components.contract import Parameters

COMPONENT = Component(
    name="own", parameters=Parameters, outputs=lambda _: (Port("v", "1"),), init=step, step=step
)
'''
SCENARIO = "duration: 1 s\nstep: 1 s\ncomponents: {a: {model: ./own.py}}\n"
RUN = """
from pathlib import Path
from pipeline.conductor import Conductor
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph
c = Conductor(build_graph(load_scenario("s.yaml")))
c.initialise()
print(c.memory.tables.board[0])
"""


RING = Path(__file__).parents[2] / "scenarios" / "van_der_pol.yaml"


def told(cache: Path) -> str:
    """What the first second of a scenario says on standard error, with this cache."""
    words = ["run", str(RING), "--until", "1s", "--out", str(cache.parent / "a.mcap"), "--overwrite"]
    environment = {**os.environ, "TOWLINE_CACHE": str(cache)}
    command = [sys.executable, "-m", "pipeline.cli", *words]
    return subprocess.run(
        command, capture_output=True, text=True, cwd=cache.parent, env=environment, timeout=120
    ).stderr


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """A cache of this module's own, empty before a first run; and what that said. The loop is compiled here only."""
    cache = tmp_path_factory.mktemp("own") / "cache"
    return cache, told(cache)


@pytest.fixture
def value(tmp_path, monkeypatch, first):
    """A function that runs the scene in a process of its own, with the module's cache, and gives its signal."""
    monkeypatch.setenv("TOWLINE_CACHE", str(first[0]))
    (tmp_path / "s.yaml").write_text(SCENARIO)

    def run(edit: float, table: float) -> float:
        (tmp_path / "own.py").write_text(MODEL.format(edit=edit))
        (tmp_path / "table.txt").write_text(f"{table}\n")
        done = subprocess.run([sys.executable, "-c", RUN], capture_output=True, text=True, cwd=tmp_path, timeout=120)
        assert done.returncode == 0, done.stderr
        return float(done.stdout)

    return run


def test_edits_of_a_users_model_and_of_its_data_are_seen(value):
    assert value(1, 5) == 6
    assert value(2, 5) == 7
    assert value(2, 8) == 10


def test_first_compile_is_announced(first):
    cache, said = first
    assert "compiling motion.van_der_pol, the loop (once; kept in" in said
    assert "compiling" not in told(cache)


def test_damaged_cache_is_compiled_anew(value, first):
    assert value(1, 5) == 6
    damaged = list(first[0].rglob("*.nbc"))
    assert damaged
    for path in damaged:
        path.write_bytes(b"")
    assert value(1, 5) == 6


def test_component_that_borrows_a_step_keeps_its_own_init():
    from dataclasses import replace

    from components.compiled import _binding_path
    from components.motion.fixed.component import COMPONENT as FIXED
    from components.motion.van_der_pol.component import COMPONENT

    borrowed = replace(COMPONENT, init=FIXED.init)
    assert _binding_path(borrowed) != _binding_path(COMPONENT)


def test_sources_of_a_shared_folder_are_this_users(tmp_path, monkeypatch):
    from components import compiled

    monkeypatch.setenv("TOWLINE_CACHE", str(tmp_path / "own"))
    folder = compiled.cache_folder.__wrapped__()
    assert folder.is_relative_to(tmp_path / "own")
    assert Path(folder).stat().st_mode & 0o077 == 0


def test_kernel_is_compiled_once_whatever_constants_it_is_called_with():
    from components.compiled import kernel

    @kernel
    def shifted(a, places, down):
        return a - places if down else a + places

    @kernel
    def both(a):
        return shifted(a, 1, True) * shifted(a, 2, False) * shifted(a, int(a), a > 0.0)

    assert both(5.0) == both.py_func(5.0)
    assert len(shifted._part.signatures) == 1
