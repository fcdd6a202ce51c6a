"""Whether a path is a folder of tracks; nothing that takes long to import."""

from __future__ import annotations

from pathlib import Path

from ..io.errors import InputError
from .store import WORK

PLAN = f"{WORK}/plan.json"
MANIFEST = f"{WORK}/manifest.json"  # hidden, so that readers of the folder with a pattern find tracks alone


def is_archive(path: str | Path) -> bool:
    """Whether it is a folder of tracks, complete or not."""
    return Path(path, PLAN).is_file()


def check_named(path: str | Path) -> None:
    """Errors: InputError for a path where there is no file of measurements, but a folder, or nothing."""
    if Path(path).is_dir():
        raise InputError(f"{path} is a folder, but none that jink track wrote; expected a file, or such a folder")
    if "/" in str(path) or "." in str(path):
        raise InputError(f"there is no file {path}")
