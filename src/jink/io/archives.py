"""Folders and ZIP archives as inputs: which of their files are meant."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path

from ..frozen import frozen
from . import unpacking
from .errors import InputError

OWN = ".rejected.parquet"  # what jink writes beside its output
OFFICE = ("[Content_Types].xml", "META-INF/manifest.xml", "mimetype")


@frozen
class Member:
    """One file of an archive."""

    archive: Path
    name: str

    def content(self) -> bytes:
        """Unpacked. Errors: InputError."""
        try:
            with zipfile.ZipFile(self.archive) as archive:
                if archive.getinfo(self.name).file_size > unpacking.most_unpacked():
                    raise unpacking.too_large(f"{self.archive}/{self.name}")
                return archive.read(self.name)
        except (OSError, RuntimeError, NotImplementedError, EOFError, zipfile.BadZipFile, zlib.error) as error:
            raise InputError(f"{self.archive}/{self.name} cannot be unpacked: {error}") from None


def members(path: Path) -> list[Member]:
    """The files of a ZIP archive by name (of a KMZ its KML); none where it is no archive, or that of an office file."""
    try:
        with path.open("rb") as handle:
            if handle.read(4) != b"PK\x03\x04":
                return []
        with zipfile.ZipFile(path) as archive:
            names = [item.filename for item in archive.infolist() if not item.is_dir()]
    except (OSError, ValueError, NotImplementedError, zipfile.BadZipFile):
        return []
    if any(name in OFFICE for name in names):
        return []
    names = sorted(name for name in names if not _hidden(Path(name)) and "__MACOSX" not in name)
    documents = [name for name in names if name.lower().endswith(".kml")]
    if len(documents) == 1:
        names = documents
    return [Member(path, name) for name in names]


def files_inside(folder: Path) -> list[Path]:
    """All files of a folder and of those in it, by name; hidden ones and jink's own rejected rows are left out."""
    found = (path for path in folder.rglob("*") if path.is_file())
    return sorted(p for p in found if not _hidden(p.relative_to(folder)) and not p.name.endswith(OWN))


def _hidden(path: Path) -> bool:
    return any(part.startswith(".") for part in path.parts)
