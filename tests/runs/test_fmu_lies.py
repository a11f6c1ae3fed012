"""FMUs that lie about themselves, archives that attack, parameters that do not fit: one line, nothing left behind."""

from __future__ import annotations

import os
import re
import shutil
import stat
import zipfile
from pathlib import Path

import pytest
from foreign import ARRAYS, BAD, BALL, KINDS, TEXTS
from misbehaving import behaviour, logged, refusal, replaced, scenario

from components.contract import Parameters
from pipeline.cli import main
from pipeline.hosts.fmu.parameters import FmuParameters
from pipeline.hosts.fmu.variables import TAKEN

pytestmark = pytest.mark.usefixtures("clean_place")

LIES = {
    "a value reference that does not exist": (
        BAD,
        2,
        replaced('valueReference="0"', 'valueReference="900"'),
        "fmi2GetReal .*'y'",
    ),
    "a value reference of an input that does not exist": (
        BAD,
        2,
        replaced('name="u" valueReference="3"', 'name="u" valueReference="77777"'),
        "fmi2SetReal .*'u'",
    ),
    "a value reference beyond 32 bits": (
        BAD,
        2,
        replaced('valueReference="0"', 'valueReference="4294967296"'),
        "value reference",
    ),
    "another GUID": (BAD, 2, replaced('guid="{8c', 'guid="{9c'), "cannot be instantiated"),
    "another GUID in FMI 3": (
        BAD,
        3,
        replaced('instantiationToken="{8c', 'instantiationToken="{9c'),
        "cannot be instantiated",
    ),
    "another library": (BAD, 2, replaced('modelIdentifier="bad"', 'modelIdentifier="good"'), "no good.so"),
    "a library elsewhere": (
        BAD,
        2,
        replaced('modelIdentifier="bad"', 'modelIdentifier="../../bad"'),
        "names no library|bad.so",
    ),
    "a start value that is no number": (BAD, 2, replaced('start="1.0"', 'start="much"'), "'largest'.*much"),
    "a type that there is not": (BAD, 2, replaced("<Real", "<Complex"), "cannot be read"),
    "an integer that is none": (BAD, 2, replaced('<Integer start="0"', '<Integer start="0.5"'), "0.5"),
    "two of a name": (BAD, 2, replaced('name="u"', 'name="at"'), "two of its variables are named 'at'"),
    "an unknown version": (BAD, 2, replaced('fmiVersion="2.0"', 'fmiVersion="4.0"'), "Unsupported FMI version"),
    "no interface": (
        BAD,
        2,
        lambda text: re.sub("<CoSimulation[^>]*>", "", text),
        "neither co-simulation nor model exchange",
    ),
    "a tool that is not here": (  # which shows by an instance that is not given
        BAD,
        2,
        lambda text: text.replace("<CoSimulation", '<CoSimulation needsExecutionTool="true"').replace("8c4e", "0000"),
        "needsExecutionTool",
    ),
    "a unit that is none": (BAD, 2, replaced('<BaseUnit s="1"', '<BaseUnit s="1" factor="0"'), "factor"),
    "no XML": (BAD, 2, replaced("</ModelVariables>", ""), "cannot be read"),
    "entities": (BAD, 2, replaced("<fmiModel", "<!DOCTYPE m [<!ENTITY e 'x'>]><fmiModel"), "document type"),
    "an array that is larger": (
        ARRAYS,
        3,
        replaced('<Dimension start="3"/>', '<Dimension start="30"/>'),
        "fmi3GetFloat64 .*'f'",
    ),
    "an array of absurd size": (
        ARRAYS,
        3,
        replaced('<Dimension start="3"/>', '<Dimension start="3000000000"/>'),
        "shape",
    ),
    "a dimension from nowhere": (
        ARRAYS,
        3,
        replaced('Dimension valueReference="1000"', 'Dimension valueReference="7"'),
        "",
    ),
    "more starts than elements": (ARRAYS, 3, replaced('start="1.0 0.0 0.0 1.0"', 'start="1 2 3"'), "'A'"),
}


@pytest.mark.parametrize("name", LIES)
def test_lying_descriptions(name, foreign, capsys):
    model, fmi, edit, why = LIES[name]
    scenario(foreign(model, fmi, edit=edit))
    text = refusal(capsys)
    assert "bad" in text
    assert re.search(why, text), text


def test_wrong_number_of_states(foreign, capsys):
    """The description has one derivative less than the binary has states."""
    path = foreign(
        BALL, 2, edit=lambda text: re.sub(r'(<Derivatives>.*?)<Unknown index="4"/>(</Derivatives>)', r"\1\2", text)
    )
    scenario(path, more=", interface: model-exchange")
    assert re.search("fmi2(Get|Set)ContinuousStates|fmi2GetDerivatives", refusal(capsys))


@pytest.mark.parametrize(
    ("fmi", "function"), [(1, "bad_fmiDoStep"), (2, "fmi2DoStep"), (3, "fmi3DoStep"), (3, "fmi3GetFloat64")]
)
def test_missing_functions(fmi, function, foreign, capsys):
    Path(f"{function}.map").write_text(f"{{ global: *; local: {function}; }};")
    scenario(foreign(BAD, fmi, f"-Wl,--version-script={function}.map"))
    text = refusal(capsys)
    assert re.search(rf"bad\.fmu.*{function.removeprefix('bad_')}", text)


def test_no_library_at_all(foreign, capsys, clean_place):
    path = foreign(BAD, 2)
    with zipfile.ZipFile(path) as archive:
        document = archive.read("modelDescription.xml")
    of_fmi_3 = foreign.library("bad", 3).read_bytes()
    for content, why in ((b"no library", "cannot be loaded.*bad.so"), (b"", "bad.so"), (of_fmi_3, "bad.fmu.*fmi2")):
        with zipfile.ZipFile("other.fmu", "w") as archive:
            archive.writestr("modelDescription.xml", document)
            archive.writestr("binaries/linux64/bad.so", content)
        scenario(Path("other.fmu"))
        assert re.search(why, refusal(capsys))
        assert Path.cwd() == clean_place
    with zipfile.ZipFile("other.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", document)
        archive.writestr("binaries/win64/bad.dll", b"")
    scenario(Path("other.fmu"))
    assert "no binary for this platform, linux64; it has some for win64" in refusal(capsys)


def test_harmless_lies(foreign, capsys):
    """Units that are defined nowhere, and a tool that may be there (pythonfmu writes so), refuse nothing."""
    scenario(foreign(BAD, 2, edit=replaced('unit="s"', 'unit="blubs"', 99)), behaviour("fine", at=0).replace(" s", ""))
    assert main(["run", "s.yaml", "--out", "s.mcap", "--json"]) == 0


def test_names_that_python_does_not_have(foreign, capsys):
    edit = {"at": "_at", "mode": "1st mode", "where": "import", "u": "copy"}
    path = foreign(BAD, 2, edit=lambda text: re.sub('name="(at|mode|where|u)"', lambda m: f'name="{edit[m[1]]}"', text))
    scenario(path, "v_at: 0.5 s, v_1st_mode: 3, import: 0, copy_: 1")
    assert "returned error" in refusal(capsys)
    logged(11)
    names = {name for name in dir(FmuParameters) if not hasattr(Parameters, name)}
    assert names == set(TAKEN)
    for name in names:
        scenario(foreign(BAD, 2, edit=replaced('name="u"', f'name="{name}"')), f"{name}_: 1")
        assert main(["check", "s.yaml", "--json"]) == 0
    scenario(foreign(BAD, 2, edit=replaced("<CoSimulation", '<CoSimulation needsExecutionTool="true"')))
    assert main(["run", "s.yaml", "--out", "s.mcap", "--json"]) == 0


@pytest.mark.parametrize(
    ("wire", "why"),
    [
        ("{text_in: bad.text_length}", "text_in.*String|text_in.*string"),
        ("{real_in: other.text_out}", "text_out.*string|text_out.*String"),
    ],
)
def test_texts_that_change_are_refused_by_name(wire, why, foreign, capsys):
    scenario(foreign(TEXTS, 2), more=f", inputs: {wire}", beside=f"  other: {{fmu: {foreign(TEXTS, 2)}}}\n")
    assert re.search(why, refusal(capsys), re.IGNORECASE)


def test_once_per_process(foreign, capsys):
    """Two of an FMU that can be instantiated once only: told apart by processes, or refused."""
    edit = replaced("<CoSimulation", '<CoSimulation canBeInstantiatedOnlyOncePerProcess="true"')
    path = foreign(BAD, 2, "ONCE", edit=edit)
    scenario(path, beside=f"  first: {{fmu: {path}}}\n")
    text = refusal(capsys)
    assert "can be instantiated only once per process, and 'first' runs it here already" in text
    assert "isolate: true" in text
    scenario(path, beside=f"  first: {{fmu: {path}, isolate: true}}\n")
    assert main(["run", "s.yaml", "--out", "s.mcap", "--json"]) == 0


def test_fixed_steps(foreign, capsys):
    edit = replaced("<CoSimulation", '<CoSimulation fixedInternalStepSize="0.01"')
    path = foreign(BAD, 3, "FIXED_STEP=0.01", edit=edit)
    scenario(path, step="12.5 ms")
    assert "fixedInternalStepSize" in refusal(capsys)
    scenario(path, step="10 ms")
    assert main(["run", "s.yaml", "--out", "s.mcap", "--json"]) == 0


def test_parameters_that_are_wrong(foreign, capsys):
    for parameters, why in (
        ("mode: 0.5", "0.5"),
        ("mode: fast", "fast"),
        ("mode: 3000000000", "3000000000"),
        ("at: 5 m", "'m' does not convert to 's'"),
        ("at: 5", "has no unit"),
        ("wher: 1", "did you mean 'where'"),
        ("y: 1 s", "y"),
    ):
        scenario(foreign(BAD, 2), parameters)
        text = refusal(capsys)
        assert why in text
        assert text.startswith("towline: s.yaml:4:")
    scenario(foreign(KINDS, 2), "choice: huge")
    assert "expected one of low, middle, high" in refusal(capsys)


def hostile(path: Path, name: str, content: bytes = b"x", mode: int = stat.S_IFREG | 0o644) -> None:
    about = zipfile.ZipInfo(name)
    about.create_system, about.external_attr = 3, mode << 16
    shutil.copyfile(path, "hostile.fmu")
    with zipfile.ZipFile("hostile.fmu", "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(about, content, zipfile.ZIP_DEFLATED)


@pytest.mark.parametrize(
    ("name", "mode", "content", "why"),
    [
        ("../evil", stat.S_IFREG, b"x", "leads out"),
        ("resources/link", stat.S_IFLNK, b"/etc/passwd", "is a link"),
        ("resources/zeros", stat.S_IFREG, bytes(210_000_000), "zip bomb"),
        ("resources/a/" * 20, stat.S_IFREG, b"", "no name that a file can have"),
    ],
)
def test_hostile_archives(name, mode, content, why, foreign, capsys, clean_place):
    hostile(foreign(BAD, 2), name, content, mode | 0o644)
    scenario(Path("hostile.fmu"))
    assert why in refusal(capsys)
    assert not (clean_place.parent / "evil").exists()


def test_a_damaged_archive(foreign, capsys):
    data = foreign(BAD, 2).read_bytes()
    for damaged in (data[:-100], data[: len(data) // 2], b"", data.replace(b"\x7fELF", b"\x7fELG"), os.urandom(1000)):
        Path("damaged.fmu").write_bytes(damaged)
        scenario(Path("damaged.fmu"))
        if damaged != data:
            assert "bad.fmu" in refusal(capsys)
