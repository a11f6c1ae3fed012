"""The digest depends on the experiment alone: not on how it is recorded, sliced or repeated."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from pipeline.digest import Digest
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario, load_scenario_text
from pipeline.wiring import build_graph

SCENARIOS = Path(__file__).parents[2] / "scenarios"


def digest(tmp_path, options=None, change=lambda scenario: scenario, name="pool_chain", seconds="12 s"):
    scenario = change(load_scenario(SCENARIOS / f"{name}.yaml", duration=seconds))
    out = tmp_path / "run.mcap"
    result = run_scenario(
        scenario, build_graph(scenario), out, replace(options or Options(), overwrite=True), lambda _: None
    )
    return result.digest


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    return digest(tmp_path_factory.mktemp("plain"))


@pytest.mark.parametrize(
    "options",
    [
        Options(),
        Options(compression="zstd"),
        Options(compression="none"),
        Options(chunk_bytes=4096),
        Options(scene=False),
        Options(slice_ticks=1),
        Options(slice_ticks=7),
    ],
    ids=["again", "zstd", "none", "small chunks", "no scene", "slices of one tick", "slices of seven"],
)
def test_recording_does_not_matter(plain, tmp_path, options):
    assert digest(tmp_path, options) == plain


@pytest.mark.parametrize("record", ["false", "every 3", "every 100 ms"])
def test_record_rate_does_not_matter(plain, tmp_path, record):
    def recorded_less(scenario):
        text = scenario.resolved_text().replace("model: tether.cable", f"model: tether.cable\n    record: {record}")
        return load_scenario_text(text, "test.yaml", scenario.folder)

    assert digest(tmp_path, change=recorded_less) == plain


def test_seed_matters(plain, tmp_path):
    def reseeded(scenario):
        return load_scenario_text(
            scenario.resolved_text().replace("seed: 1\n", "seed: 2\n"), "test.yaml", scenario.folder
        )

    assert digest(tmp_path, change=reseeded) != plain


def test_chain_goes_on_from_a_block_end():
    import numpy as np

    rows = [np.random.default_rng(i).random((5, 3)) for i in range(6)]
    whole, first = Digest(["a"]), Digest(["a"])
    for digest_ in (whole, first):
        for row in rows[:3]:
            digest_.update("a", row)
        digest_.end_block()
    second = Digest(["a"], first.chains())
    for row in rows[3:]:
        whole.update("a", row)
        second.update("a", row)
    assert second.total() == whole.total()
    second.update("a", rows[0])
    assert second.total() != whole.total()
