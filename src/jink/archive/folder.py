"""Whether a path is a folder of tracks; nothing that takes long to import."""

from __future__ import annotations

from pathlib import Path

from .store import WORK

PLAN = f"{WORK}/plan.json"
MANIFEST = f"{WORK}/manifest.json"  # hidden, so that readers of the folder with a pattern find tracks alone


def is_archive(path: str | Path) -> bool:
    """Whether it is a folder of tracks, complete or not."""
    return Path(path, PLAN).is_file()
