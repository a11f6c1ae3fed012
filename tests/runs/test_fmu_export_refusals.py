"""What `towline fmu` refuses, each in one line."""

from __future__ import annotations

import os
import zipfile
from pathlib import Path

from pipeline.cli import main

ROOT = Path(__file__).parents[2]


def told_error(capsys, *words: str) -> str:
    """The one line that a command which fails leaves."""
    assert main(["fmu", *words]) == 1
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    return lines[0]


def test_errors_are_one_line(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    fixed = ["build", "motion.fixed", "--param", "position=[1 m, 2 m, 3 m]"]
    assert "did you mean 'tether.cable'?" in told_error(capsys, "build", "tether.cabel")
    assert "did you mean 'position'?" in told_error(capsys, *fixed, "--param", "positon=[1 m, 2 m, 3 m]")
    assert "is a scenario; name a component of it" in told_error(capsys, "build", f"{ROOT}/scenarios/bond_mass.yaml")
    assert "has no component 'x'" in told_error(capsys, "build", f"{ROOT}/scenarios/bond_mass.yaml#x")
    assert "--step" in told_error(capsys, *fixed, "--step", "0 s")
    assert "cannot be written" in told_error(capsys, *fixed, "-o", "no/such/folder.fmu")
    (tmp_path / "bad.fmu").write_bytes(b"PK\x05\x06" + bytes(18))
    assert "it has no modelDescription.xml" in told_error(capsys, "info", "bad.fmu")
    with zipfile.ZipFile("broken.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", "<fmiModelDescription fmiVersion='2.0'")
    assert "its modelDescription.xml cannot be read" in told_error(capsys, "info", "broken.fmu")
    with zipfile.ZipFile("bomb.fmu", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", bytes(300_000_000))
    assert "that claim to hold 300 MB" in told_error(capsys, "info", "bomb.fmu")
    monkeypatch.setenv("PATH", os.fspath(tmp_path))
    assert "no C compiler found (cc, gcc, clang)" in told_error(capsys, *fixed)


def test_python_component_is_refused(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.py").write_text(
        "from components.contract import Component, Parameters, Port\n"
        "def step(t_ns, dt_ns, p, u, x, y, w):\n    y[0] = 1.0\n    return 0\n"
        "COMPONENT = Component('own', Parameters, step, step, lambda _: (Port('v', '1'),), compiled=False)\n"
    )
    assert "own is a Python callable" in told_error(capsys, "build", "./own.py")
