"""`jink track` of files that are larger than the memory it may take: share by share, straight into the output."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from ..io.errors import InputError

UNITS = {"": 1, "k": 10**3, "m": 10**6, "g": 10**9, "t": 10**12, "ki": 2**10, "mi": 2**20, "gi": 2**30, "ti": 2**40}
CGROUP = "/sys/fs/cgroup/memory.max"
LEAST = 600_000_000

Progress = Callable[[str, int, int], None]
Page = Callable[[Any, Path, dict[str, Any]], None]  # tracks, where to, summary


def memory_of(given: str | None) -> int:
    """`2GB` or `1.5 GiB` to bytes; None: a quarter of what the machine or its container has. Errors: InputError."""
    if given is None:
        return max(LEAST, _available() // 4)
    found = re.fullmatch(r"\s*(\d+(?:\.\d*)?)\s*([kmgt]?i?)b?\s*", given.lower())
    if not found or found[2] not in UNITS or float(found[1]) * UNITS[found[2]] < LEAST:
        raise InputError(f"--memory is {given!r}; expected at least {LEAST // 10**6}MB, for example 2GB")
    return int(float(found[1]) * UNITS[found[2]])


def _available() -> int:
    try:
        bytes_ = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        bytes_ = 8 * 2**30
    try:
        return min(bytes_, int(Path(CGROUP).read_text(encoding="ascii")))
    except (OSError, ValueError):
        return bytes_


def track_large(
    inputs: Sequence[str],
    reading: Any,
    settings: Any,
    memory: int,
    output: tuple[Path, str] | None,
    rejected: Path | None,
    progress: Progress,
    *,
    safe: bool = False,
    page: tuple[Path, Page] | None = None,
) -> tuple[dict[str, Any], list[Path]] | None:
    """The summary and the files that were written; None where the files cannot be divided. Errors: InputError.

    output: where tracks go, and in which format; rejected: where rows go that are in no track;
    safe: no cell of CSV is a formula; page: where a page goes, and what writes it of a sample of the targets.
    """
    from ..io.sinks import check_streamed, write_stream
    from ..io.spreadsheets import harmless
    from ..io.temporary import folder_in
    from ..io.writing import atomically
    from .large import Large
    from .sampled import Sampled

    if output is not None:
        check_streamed(*output)
    beside = output[0].parent if output else page[0].parent if page else None
    with folder_in(beside) as folder:
        large = Large.of(inputs, reading, settings, memory, folder, progress)
        if large is None:
            return None
        sample = Sampled()
        tables = large.tables() if page is None else map(sample.take, large.tables())
        written = [given[0] for given in (output, page) if given]
        with atomically(*written) as names:
            if output is None:
                for _ in tables:
                    pass
            else:
                path, kind = output
                write_stream(map(harmless, tables) if safe else tables, names[0], kind, packed=path.suffix == ".gz")
            summary = large.summary()
            if page is not None:
                said = sample.said()
                summary |= {"sample": said} if said else {}
                page[1](sample.tracks(), names[-1], summary)
            if written and rejected is not None and (large.lost or rejected.exists()):
                with atomically(rejected) as (beside_it,):
                    write_stream(_some(large), beside_it, "parquet")
                written.append(rejected)
    return summary, written


def _some(large: Any) -> Iterator[Any]:
    """The rejected rows, or a table of none."""
    from ..io.rejected import together

    if large.lost:
        yield from large.rejected()
    else:
        yield together([])
