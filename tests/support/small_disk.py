"""A small disk that fills up, for tests of what is said then."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


def mounted(folder: Path, options: str) -> bool:
    """Whether a small disk could be mounted there, or could get another size."""
    mount = ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder)]
    with suppress(OSError):
        return subprocess.run(mount, capture_output=True, check=False).returncode == 0
    return False


@contextmanager
def place_for_a_disk(folder: Path) -> Iterator[Path]:
    """Where a disk may be mounted; it is taken away after."""
    disk = folder / "disk"
    disk.mkdir()
    yield disk
    if os.path.ismount(disk):
        subprocess.run(["umount", "-l", str(disk)], check=True)
