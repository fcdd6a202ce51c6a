"""Archives with one target that is larger than the memory, and files that are added later: cost and equality."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import polars as pl

from jink.archive import run
from jink.io.loading import Reading
from jink.tracking.prepare import Settings

from .archive import tracked

MEMORY = 2_000_000_000


def rows_of(output: Path) -> pl.DataFrame:
    """All tracks of a folder, by target and time."""
    frames = [pl.read_parquet(path, hive_partitioning=False) for path in sorted(output.glob("bucket=*/*"))]
    return pl.concat(frames).sort("target", "time", maintain_order=True)


def same(one: pl.DataFrame, other: pl.DataFrame) -> str:
    """In words: whether two tables have the same rows and values."""
    other = other.sort("target", "time", maintain_order=True).select(
        pl.col(name).cast(kind) for name, kind in one.schema.items()
    )
    differ = [name for name in one.columns if one.height != other.height or not one[name].equals(other[name])]
    return "all rows and values are the same" if not differ else f"they differ in {', '.join(differ)}"


def at_once(files: Sequence[Path], output: Path) -> str:
    """Whether a folder has the tracks of one table in memory."""
    whole = output.with_name("whole.parquet")
    names = [str(path) for path in files]
    more = ["--memory", "100GB", "--json"]
    words = [sys.executable, "-m", "jink", "track", *names, "-o", str(whole), *more]
    subprocess.run(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
    found = same(rows_of(output), pl.read_parquet(whole))
    whole.unlink()
    return f"beside one table in memory: {found}"


def appended(files: Sequence[Path], output: Path) -> str:
    """The last file added to a folder of the others, and then a file of one target: what is tracked again, and whether
    the tracks are those of a run over all.
    """
    days, whole, one = output.with_name("days"), output.with_name("whole"), output.with_name("one.parquet")
    before = tracked(files[:-1], days)["cpu"]
    added = tracked(files[-1:], days, "--append")["cpu"]
    _decided_by(files, len(files) - 1, whole)
    found = same(rows_of(days), rows_of(whole))
    last = pl.read_parquet(files[-1])
    later = last.filter(pl.col("icao24") == last["icao24"][0]).with_columns(pl.col("time") + 86_400.0)
    later.write_parquet(one)
    made = _times(days)
    alone = tracked([one], days, "--append")["cpu"]
    changed = sum(made.get(path) != at for path, at in _times(days).items())
    return (
        f"added: {len(files) - 1} files {before:.1f} s of CPU, the last one {added:.1f} s; beside a run over all: "
        f"{found}; a file of one target {alone:.1f} s, {changed} of {len(made)} buckets tracked again"
    )


def _times(output: Path) -> dict[str, int]:
    return {str(path): path.stat().st_mtime_ns for path in output.glob("bucket=*/*")}


def _decided_by(files: Sequence[Path], first: int, output: Path) -> None:
    """A run over all files, of which the first ones decide the noise and the filter, as they do where others follow."""
    made = run._new_plan

    def planned(*given: Any) -> Any:
        return replace(made(*given), first=first)

    run._new_plan = planned
    try:
        how = run.How(memory=MEMORY, processes=1)
        run.track_archive(files, f"{output}/", Reading(), Settings(), how, lambda event: None)
    finally:
        run._new_plan = made
