"""The archive that an FMU is: its description read, and its files extracted, both as from a stranger."""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pipeline import archive
from pipeline.errors import TowlineError
from pipeline.fmu.platforms import folder_here

DOCUMENT = "modelDescription.xml"
LARGEST = 256_000_000  # bytes of the description, far above any honest one
VERSIONS = {"1.0": 1, "2.0": 2}  # 3.x: 3
_BINARY = re.compile(r"binaries/([^/]+)/.")


def names(path: Path) -> list[str]:
    """The archive's files, its description among them. Raises TowlineError where it is unsafe or no FMU."""
    sizes = archive.members(path, "FMU")
    if DOCUMENT not in sizes:
        raise TowlineError(f"{path}: no FMU: it has no {DOCUMENT}")
    return list(sizes)


def model_description(path: Path) -> Any:
    """The description as fmpy reads it, not validated. Raises TowlineError.

    fmpy gets the checked text alone, since it would read other documents of the archive as they are.
    """
    data = archive.read(path, "FMU", DOCUMENT, LARGEST)
    from pipeline.xml_source import parse_xml  # with lxml, which not every command needs

    parse_xml(data, f"{path}: its {DOCUMENT}")
    import fmpy

    alone = io.BytesIO()
    with zipfile.ZipFile(alone, "w") as copy:
        copy.writestr(DOCUMENT, data)
    try:
        return fmpy.read_model_description(alone, validate=False)
    except Exception as error:  # of many kinds, from the parser's to those of values that are no numbers
        text = (str(error).splitlines() or [type(error).__name__])[0]
        raise TowlineError(f"{path}: its {DOCUMENT} cannot be read: {text}") from error


def platforms(files: list[str]) -> tuple[str, ...]:
    """The platforms that the archive's files have binaries for."""
    return tuple(sorted({match[1] for name in files if (match := _BINARY.match(name))}))


def binary(path: Path, fmi: str, identifier: str) -> str:
    """The name in the archive of the interface's library for this machine. Raises TowlineError if there is none.

    fmi: version as the description gives it. identifier: the interface's modelIdentifier, of a stranger too.
    """
    files, wanted = names(path), folder_here(VERSIONS.get(fmi, 3))
    name = f"binaries/{wanted}/{identifier}.so"
    if name in files and "/" not in identifier:
        return name
    found = platforms(files)
    if wanted in found:
        raise TowlineError(f"{path}: its binaries for {wanted} have no {identifier}.so, which its {DOCUMENT} names")
    told = f"it has some for {', '.join(found)}" if found else "it has none at all"
    raise TowlineError(f"{path}: no binary for this platform, {wanted}; {told}")


@contextmanager
def extracted(path: Path) -> Iterator[Path]:
    """The FMU's files in a private temporary folder, removed on every way out. Raises TowlineError."""
    names(path)
    with archive.extracted(path, "FMU") as folder:
        yield folder
