"""Archives that no FMU should be: each is refused by one line that names it, and leaves no folder behind."""

from __future__ import annotations

import fcntl
import os
import signal
import stat
import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path

import pytest

from pipeline import archive
from pipeline.errors import TowlineError
from pipeline.fmu.archive import binary, extracted, model_description
from pipeline.fmu.information import information

DOCUMENT = "modelDescription.xml"
PLAIN = "<fmiModelDescription fmiVersion='2.0' modelName='m' guid='g'><ModelVariables/></fmiModelDescription>"
BINARY = "binaries/linux64/m.so"
LAUGHS = "".join(f'<!ENTITY l{i} "{f"&l{i - 1};" * 10}">' for i in range(1, 10))


@pytest.fixture(autouse=True)
def private(tmp_path, monkeypatch) -> Path:
    """A temporary folder of the test's own, empty again afterwards."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    yield folder
    assert list(folder.iterdir()) == []


def packed(path: Path, *extra: tuple[str | zipfile.ZipInfo, bytes], document: str | bytes = PLAIN) -> Path:
    """An archive with a description, a library and more."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as out:
        out.writestr(DOCUMENT, document)
        out.writestr(BINARY, b"\x7fELF")
        for name, content in extra:
            out.writestr(name, content)
    return path


def member(name: str, mode: int = stat.S_IFREG | 0o644) -> zipfile.ZipInfo:
    about = zipfile.ZipInfo(name)
    about.create_system, about.external_attr = 3, mode << 16
    return about


def edited(path: Path, old: bytes, new: bytes, count: int = -1) -> Path:
    """The archive with its bytes changed: what zipfile itself would not write."""
    data = path.read_bytes()
    assert old in data
    path.write_bytes(data.replace(old, new, count))
    return path


def refusal(path: Path) -> str:
    with pytest.raises(TowlineError) as caught, extracted(path):
        pass
    text = str(caught.value)
    assert str(path) in text
    assert len(text.splitlines()) == 1
    return text


def test_files_are_extracted_into_a_private_folder_that_goes(tmp_path, private):
    path = packed(tmp_path / "m.fmu", ("resources/a/b.txt", b"b" * 3_000_000), ("resources/empty/", b""))
    with extracted(path) as folder:
        assert folder.parent == private
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700
        assert (folder / "resources/a/b.txt").read_bytes() == b"b" * 3_000_000
        assert sorted(p.name for p in folder.iterdir()) == ["binaries", DOCUMENT, "resources"]
        (folder / "resources").chmod(0o500)  # an FMU may do so
    assert not folder.exists()


@pytest.mark.parametrize(
    "name", ["../evil", "a/../../evil", "/etc/evil", "C:/evil", "c:evil", "resources\\..\\evil", "..", "/"]
)
def test_paths_outside(name, tmp_path):
    assert "leads out of the archive's folder" in refusal(packed(tmp_path / "m.fmu", (name, b"x")))
    assert sorted(p.name for p in tmp_path.iterdir()) == ["m.fmu", "temporary"]


def test_a_name_that_ends_in_a_nul(tmp_path):
    path = packed(tmp_path / "m.fmu", ("resources/evilX.txt", b"x"))
    assert "leads out" in refusal(edited(path, b"resources/evilX", b"resources/evil\0"))


@pytest.mark.parametrize("kind", [stat.S_IFLNK, stat.S_IFIFO, stat.S_IFCHR, stat.S_IFBLK, stat.S_IFSOCK])
def test_special_members(kind, tmp_path):
    path = packed(tmp_path / "m.fmu", (member("resources/link", kind | 0o777), b"/etc/passwd"))
    assert "is a link or a device" in refusal(path)


@pytest.mark.parametrize(
    ("first", "second", "why"),
    [
        ("resources/a", "resources/a", "is there twice"),
        ("resources/a", "resources/./a", "is there twice"),
        ("resources/a", "resources/a/b", "is in a folder that is a file"),
        ("resources/a/b", "resources/a", "is there twice"),
    ],
)
@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_members_twice(first, second, why, tmp_path):
    assert why in refusal(packed(tmp_path / "m.fmu", (first, b"1"), (second, b"2")))


def test_folders_given_more_than_once_are_no_clash(tmp_path):
    path = packed(tmp_path / "m.fmu", ("resources/a/b", b""), ("resources/", b""), ("resources/a/", b""))
    with extracted(path) as folder:
        assert (folder / "resources/a/b").is_file()


@pytest.mark.parametrize("name", ["/".join("a" * 33), "x" * 256, "ä" * 128])
def test_deep_and_long_names(name, tmp_path):
    assert "no name that a file can have" in refusal(packed(tmp_path / "m.fmu", (name, b"")))


def test_bomb_by_ratio(tmp_path):
    text = refusal(packed(tmp_path / "m.fmu", ("resources/zeros", bytes(201_000_000))))
    assert "that claim to hold 201 MB, as a zip bomb does" in text


def test_bomb_that_claims_less_than_it_holds(tmp_path):
    """The claim is what is extracted, and the checksum is of all."""
    path = packed(tmp_path / "m.fmu", ("resources/zeros", bytes(5_000_000)))
    edited(path, (5_000_000).to_bytes(4, "little"), (50).to_bytes(4, "little"))
    assert "Bad CRC-32" in refusal(path)


def test_bomb_of_overlapping_members(tmp_path):
    """One block of data behind many names, as Fifield's zip bomb has it: each claims nearly the whole file."""
    path = packed(tmp_path / "m.fmu", ("resources/a", os.urandom(1000)), ("resources/b", b"x"))
    data = path.read_bytes()
    small, entry = data.rindex(b"PK\x01\x02"), 20
    path.write_bytes(data[: small + entry] + (len(data)).to_bytes(4, "little") + data[small + entry + 4 :])
    assert "overlap" in refusal(path)


def test_too_many_members(tmp_path, monkeypatch):
    monkeypatch.setattr(archive, "MOST_MEMBERS", 100)
    path = packed(tmp_path / "m.fmu", *((f"resources/{i}", b"") for i in range(99)))
    assert "101 members; at most 100" in refusal(path)


def test_encrypted(tmp_path):
    path = packed(tmp_path / "m.fmu", ("resources/secret", b"x"))
    data = bytearray(path.read_bytes())
    for mark, flags in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        data[data.rindex(mark) + flags] |= 1
    path.write_bytes(data)
    assert "is encrypted" in refusal(path)


def test_damage(tmp_path):
    """A byte changed anywhere in a member, and the file cut anywhere, gives one line or the whole contents."""
    path = packed(tmp_path / "m.fmu", ("resources/a", bytes(range(256)) * 4))
    whole = path.read_bytes()
    changed = bytearray(whole)
    changed[whole.index(b"resources/a") + 40] ^= 0xFF
    path.write_bytes(changed)
    assert "damaged" in refusal(path)
    for length in range(0, len(whole), 37):
        path.write_bytes(whole[:length])
        assert "damaged" in refusal(path)
    path.write_bytes(edited(packed(path, ("resources/a", b"abc" * 99)), b"\x08\x00", b"\x63\x00").read_bytes())
    assert "compression" in refusal(path)


def test_no_archive(tmp_path):
    assert "No such file" in refusal(tmp_path / "none.fmu")
    assert "no file" in refusal(tmp_path)
    os.mkfifo(tmp_path / "fifo.fmu")
    assert "no file" in refusal(tmp_path / "fifo.fmu")


def test_full_disk(tmp_path, monkeypatch):
    monkeypatch.setattr(archive, "_write", lambda *_: (_ for _ in ()).throw(OSError(28, "No space left on device")))
    assert "cannot be extracted into" in refusal(packed(tmp_path / "m.fmu"))


def described(path: Path) -> str:
    with pytest.raises(TowlineError) as caught:
        model_description(path)
    assert len(str(caught.value).splitlines()) == 1
    return str(caught.value)


@pytest.mark.parametrize(
    ("document", "why"),
    [
        (f"<!DOCTYPE m [<!ENTITY l0 'ha'>{LAUGHS}]><m fmiVersion='2.0'>&l9;</m>", "entity|document type"),
        (f"<!DOCTYPE m [<!ENTITY l0 'ha'>{LAUGHS}]><m fmiVersion='&l9;'/>", "entity|document type"),
        ("<!DOCTYPE m [<!ENTITY f SYSTEM 'file:///etc/passwd'>]><m fmiVersion='2.0'>&f;</m>", "document type"),
        ("<!DOCTYPE m SYSTEM 'http://127.0.0.1:9/m.dtd'><m fmiVersion='2.0'/>", "document type"),
        ("<!DOCTYPE m [<!ENTITY a 'b'>]><m fmiVersion='2.0'/>".encode("utf-16"), "document type"),
        ("<a>" * 300 + "</a>" * 300, "depth"),
        ("<m fmiVersion='2.0'", "cannot be read: "),
        ("", "cannot be read: "),
        (b"\xff\xfe\x00", "cannot be read: "),
        ("<m fmiVersion='4.0'/>", "cannot be read: Unsupported FMI version"),
        ("<m/>", "cannot be read"),
    ],
)
def test_hostile_descriptions(document, why, tmp_path):
    text = described(packed(tmp_path / "m.fmu", document=document))
    assert any(part in text for part in why.split("|")), text


def test_description_missing_or_too_large(tmp_path, monkeypatch):
    with zipfile.ZipFile(tmp_path / "none.fmu", "w") as out:
        out.writestr(BINARY, b"")
    assert "it has no modelDescription.xml" in described(tmp_path / "none.fmu")
    assert "it has no modelDescription.xml" in refusal(tmp_path / "none.fmu")
    monkeypatch.setattr("pipeline.fmu.archive.LARGEST", 50)
    assert "claims 0 MB" in described(packed(tmp_path / "m.fmu"))


def test_values_that_are_no_numbers_are_told(tmp_path):
    document = PLAIN.replace("<ModelVariables/>", "<DefaultExperiment stepSize='often'/><ModelVariables/>")
    with pytest.raises(TowlineError, match=r"its modelDescription.xml cannot be read: .*'often'"):
        information(packed(tmp_path / "m.fmu", document=document))


def test_only_the_checked_description_is_read(tmp_path):
    """fmpy would read a build description too, as it is."""
    fmi3 = PLAIN.replace("2.0", "3.0").replace("guid", "instantiationToken")
    path = packed(tmp_path / "m.fmu", ("sources/buildDescription.xml", b"<no xml"), document=fmi3)
    assert model_description(path).modelName == "m"


def test_binaries(tmp_path):
    path = packed(tmp_path / "m.fmu", ("binaries/win64/m.dll", b""))
    assert binary(path, "2.0", "m") == BINARY
    for fmi, identifier, why in (
        ("3.0", "m", "no binary for this platform, x86_64-linux; it has some for linux64, win64"),
        ("2.0", "n", "binaries for linux64 have no n.so"),
        ("2.0", "../linux64/m", "have no ../linux64/m.so"),
    ):
        with pytest.raises(TowlineError, match=why):
            binary(path, fmi, identifier)
    with zipfile.ZipFile(tmp_path / "source.fmu", "w") as out:
        out.writestr(DOCUMENT, PLAIN)
    with pytest.raises(TowlineError, match="it has none at all"):
        binary(tmp_path / "source.fmu", "2.0", "m")


HOLDING = """
import sys, tempfile
from pathlib import Path
from pipeline import interrupts
from pipeline.fmu.archive import extracted
import signal, time
interrupts.begin()
tempfile.tempdir = sys.argv[2]
with extracted(Path(sys.argv[1])) as folder:
    print(folder, flush=True)
    time.sleep(60)
"""


def holder(path: Path, private: Path) -> tuple[subprocess.Popen, Path]:
    """A process that holds an FMU's folder."""
    words = [sys.executable, "-c", HOLDING, str(path), str(private)]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    assert process.stdout is not None
    return process, Path(process.stdout.readline().strip())


def test_folders_of_terminated_and_killed_processes(tmp_path, private):
    path = packed(tmp_path / "m.fmu")
    living, theirs = holder(path, private)
    killed, left = holder(path, private)
    killed.kill()
    killed.wait(10)
    for folder in (theirs, left):
        os.utime(folder, (time.time() - 3600,) * 2)
    (private / f"{archive.PREFIX}elsewhere").symlink_to(tmp_path)
    with extracted(path):
        assert not left.exists()  # swept
        assert theirs.exists()
    living.send_signal(signal.SIGTERM)
    living.wait(10)
    assert not theirs.exists()
    (private / f"{archive.PREFIX}elsewhere").unlink()


def test_a_folder_is_locked_while_it_is_in_use(tmp_path):
    with extracted(packed(tmp_path / "m.fmu")) as folder:
        other = os.open(folder, os.O_RDONLY)
        with pytest.raises(BlockingIOError):
            fcntl.flock(other, fcntl.LOCK_EX | fcntl.LOCK_NB)
        os.close(other)
