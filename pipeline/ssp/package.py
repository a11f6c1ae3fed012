"""The files of a system structure: members of an SSP archive, or beside an SSD or OSP file."""

from __future__ import annotations

import posixpath
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from pipeline import archive
from pipeline.errors import TowlineError
from pipeline.xml_source import parse_xml

LARGEST = 64_000_000  # bytes of one document
STRUCTURE = "SystemStructure.ssd"


@dataclass(frozen=True)
class Package:
    """folder: where its files are. shown: the package's name in messages. is_closed: paths must not lead out of it."""

    folder: Path
    shown: str
    is_closed: bool

    def path(self, source: str, base: str = "") -> Path:
        """The file that a source names, relative to the document `base`. Raises TowlineError."""
        parts = urlsplit(source)
        if parts.scheme not in ("", "file") or parts.netloc:
            raise TowlineError(f"{self.shown}: '{source[:200]}' is not a file of the package; only such are read")
        name = unquote(parts.path)
        path = Path(name) if name.startswith("/") else self.folder / posixpath.dirname(base) / name
        try:
            is_inside, is_file = path.resolve().is_relative_to(self.folder.resolve()), path.is_file()
        except OSError as error:
            raise TowlineError(f"{self.shown}: '{source[:200]}' cannot be read: {error.strerror}") from error
        if self.is_closed and not is_inside:
            raise TowlineError(f"{self.shown}: '{source[:200]}' leads out of the package")
        if not is_file:
            raise TowlineError(f"{self.shown}: there is no file '{source[:200]}'")
        return path

    def document(self, source: str, base: str = "") -> Any:
        """The root of one of its XML documents. Raises TowlineError."""
        path = self.path(source, base)
        if path.stat().st_size > LARGEST:
            raise TowlineError(f"{self.shown}: {source} has {path.stat().st_size / 1e6:.0f} MB; it is not read")
        try:
            return parse_xml(path.read_bytes(), f"{self.shown}: {source}")
        except OSError as error:
            raise TowlineError(f"{self.shown}: {source} cannot be read: {error.strerror}") from error


@contextmanager
def opened(path: Path) -> Iterator[tuple[Package, Any]]:
    """The package that a structure is in, and the root of the structure. Raises TowlineError."""
    if path.suffix.lower() == ".ssp":
        with archive.extracted(path, "SSP") as folder:
            package = Package(folder, str(path), is_closed=True)
            yield package, package.document(STRUCTURE)
    else:
        package = Package(path.absolute().parent, str(path), is_closed=False)
        if not path.is_file():
            raise TowlineError(f"{path}: no such file")
        yield package, package.document(path.name)


def copied(fmus: dict[Path, str], folder: Path) -> None:
    """Copy FMUs out of a package. Raises TowlineError."""
    try:
        for source, name in fmus.items():
            folder.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, folder / name)
    except OSError as error:
        raise TowlineError(f"{folder}: cannot be written: {error.strerror or error}") from error
