"""The Reference FMUs of the FMI project against the results inside them, where TOWLINE_REFERENCE_FMUS names a folder.

The same is done with a folder of the tests' own FMUs laid out alike, whose results are fmpy's.
"""

from __future__ import annotations

import csv
import io
import json
import os
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.simulation import simulate_fmu
from foreign import BALL, STAIR, VAN_DER_POL

from pipeline.cli import main
from pipeline.log.reader import open_log
from pipeline.ssp.variables import elements

FOLDER = os.environ.get("TOWLINE_REFERENCE_FMUS", "")
FMUS = sorted(Path(FOLDER).rglob("*.fmu")) if FOLDER else []
BAND = 0.02  # of a signal's range: the references are another solver's, of Euler's method among them, with 6 digits
INTERFACES = {"co-simulation": "coSimulation", "model-exchange": "modelExchange"}


def member(path: Path, end: str) -> str:
    """The text of the archive's first member with this end of its name; "" if there is none."""
    with zipfile.ZipFile(path) as archive:
        names = [name for name in archive.namelist() if name.lower().endswith(end)]
        return archive.read(names[0]).decode("utf-8-sig") if names else ""


def reference(path: Path) -> dict[str, np.ndarray]:
    """Columns of the reference result in the FMU."""
    rows = list(csv.reader(io.StringIO(member(path, "_ref.csv"))))
    return dict(zip(rows[0], np.array(rows[1:], np.float64).T, strict=True)) if rows else {}


def outside(times: np.ndarray, found: np.ndarray, at: np.ndarray, expected: np.ndarray, h: float) -> float:
    """The largest distance from what the reference is within a step around each time, in parts of its range."""
    size = max(float(np.ptp(expected)), 1e-9)
    worst = 0.0
    for t, y in zip(times, found, strict=True):
        if t > at[-1]:
            break
        near = expected[(at >= t - h) & (at <= t + h)]
        near = np.append(near, np.interp([t - h, t, t + h], at, expected))
        worst = max(worst, (near.min() - y) / size, (y - near.max()) / size)
    return worst


def check(path: Path, folder: Path, capsys) -> dict[str, float]:
    """How far the run's outputs are outside of the reference's, by interface and output."""
    about, expected = fmpy.read_model_description(str(path), validate=False), reference(path)
    interfaces = [name for name, attribute in INTERFACES.items() if getattr(about, attribute) is not None]
    interfaces = [name for name in interfaces if (about.fmiVersion, name) != ("1.0", "model-exchange")]
    if not interfaces:
        pytest.skip("it has no interface that is run: scheduled execution, or model exchange of FMI 1.0")
    if not expected:
        pytest.skip("it has no reference result (*_ref.csv)")
    if member(path, "_in.csv"):
        pytest.skip("its reference result is of inputs over time (*_in.csv), which no scenario plays")
    at = expected.pop(next(name for name in expected if name.lower() == "time"))
    experiment = about.defaultExperiment
    h = float(experiment.stepSize) if experiment and experiment.stepSize else float(np.median(np.diff(at)))
    stop = int(float(at[-1]) / h + 1e-6) * h
    worst = {}
    for interface in interfaces:
        (folder / "s.yaml").write_text(
            f"duration: {stop:.9g} s\nstep: {h:.9g} s\nscene: false\n"
            f"components:\n  fmu: {{fmu: {path}, interface: {interface}}}\n"
        )
        log = folder / f"{interface}.mcap"
        status = main(["run", str(folder / "s.yaml"), "--out", str(log), "--json"])
        error = json.loads(capsys.readouterr().out).get("error", "")
        # An FMU may end the simulation where its reference ends, as the Stair does.
        assert status == 0 or (f"at t = {stop:.9g} s" in error and "ends the simulation" in error), error
        opened, known = open_log(log), elements(path)
        for name, column in expected.items():
            one = known.get(name)
            if one is None or one.variable.causality != "output" or one.position is None:
                continue
            values = np.asarray(opened.port("fmu", one.variable.name)).reshape(opened.times("fmu").size, -1)
            numbers = (values[:, one.position] - one.variable.unit.offset) / one.variable.unit.factor
            seconds = opened.times("fmu") * 1e-9
            worst[f"{interface} {name}"] = outside(seconds, numbers, at, column, h)
    return worst


@pytest.mark.skipif(not FOLDER, reason="TOWLINE_REFERENCE_FMUS names no folder of the Reference FMUs")
@pytest.mark.parametrize("path", FMUS, ids=lambda path: "-".join(path.relative_to(FOLDER).with_suffix("").parts))
def test_reference_fmus(path, tmp_path, capsys):
    worst = check(path, tmp_path, capsys)
    assert worst, "none of the reference's variables is an output"
    assert max(worst.values()) <= BAND, worst


def laid_out(foreign, folder: Path, model, fmi: int, scale: float = 1.0) -> Path:
    """An FMU with documentation/NAME_ref.csv in it, fmpy's result; scale: of what is wrong in it."""
    plain = foreign(model, fmi)
    outputs = [one.name for one in model.variables if one.causality == "output"]
    kind = "CoSimulation" if fmi == 1 else "ModelExchange"
    rows = simulate_fmu(str(plain), stop_time=1.0, output=outputs, output_interval=0.01, fmi_type=kind)
    text = ",".join(f'"{name}"' for name in rows.dtype.names) + "\n"
    for row in rows.tolist():
        text += ",".join(f"{number * (scale if k else 1.0):.6g}" for k, number in enumerate(row)) + "\n"
    path = folder / f"{fmi}.0" / f"{model.name}.fmu"
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(plain.read_bytes())
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr(f"documentation/{model.name}_ref.csv", text)
    return path


@pytest.mark.parametrize("fmi", [1, 2, 3])
@pytest.mark.parametrize("model", [VAN_DER_POL, BALL, STAIR], ids=lambda model: model.name)
def test_own_fmus_laid_out_alike(model, fmi, foreign, tmp_path, capsys):
    path = laid_out(foreign, tmp_path, model, fmi)
    worst = check(path, tmp_path, capsys)
    outputs = [one.name for one in model.variables if one.causality == "output"]
    interfaces = ["co-simulation"] if fmi == 1 else list(INTERFACES)
    assert sorted(worst) == sorted(f"{interface} {name}" for interface in interfaces for name in outputs)
    assert max(worst.values()) <= BAND, worst


def test_a_wrong_reference_is_seen(foreign, tmp_path, capsys):
    path = laid_out(foreign, tmp_path, VAN_DER_POL, 2, scale=1.1)
    assert min(check(path, tmp_path, capsys).values()) > BAND


def test_one_that_ends_the_simulation_where_its_reference_ends(foreign, tmp_path, capsys):
    """As the Stair of the FMI project does: at its fourth step, and at 1 s."""
    path = laid_out(foreign, tmp_path, STAIR, 3)
    ending = tmp_path / "ending.fmu"
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(ending, "w") as out:
        for name in source.namelist():
            if not name.endswith(".so"):
                out.writestr(name, source.read(name))
        out.write(foreign.library("stair", 3, "LAST_AT=4"), "binaries/x86_64-linux/stair.so")
    assert max(check(ending, tmp_path, capsys).values()) <= BAND
