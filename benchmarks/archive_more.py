"""Archives with one target that is larger than the memory, and files that are added later: cost and equality."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from jink.archive import run
from jink.io.loading import Reading
from jink.tracking.prepare import Settings

from .archive_run import tracked

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
    the tracks are those of a run over all. Carrying states over would cost at least what the last file takes alone.
    """
    days, whole, one = output.with_name("days"), output.with_name("whole"), output.with_name("one.parquet")
    before = tracked(files[:-1], days)["cpu"]
    earlier = rows_of(days)
    added = tracked(files[-1:], days, "--append")["cpu"]
    _decided_by(files, len(files) - 1, whole)
    later = rows_of(days)
    found, moved = same(later, rows_of(whole)), changed_by(earlier, later)
    by_itself = tracked(files[-1:], output.with_name("last"))["cpu"]
    last = pl.read_parquet(files[-1])
    more = last.filter(pl.col("icao24") == last["icao24"][0]).with_columns(pl.col("time") + 86_400.0)
    more.write_parquet(one)
    made = _times(days)
    alone = tracked([one], days, "--append")["cpu"]
    changed = sum(made.get(path) != at for path, at in _times(days).items())
    costs = f"{len(files) - 1} files {before:.1f} s of CPU, the last one {added:.1f} s, by itself {by_itself:.1f} s"
    single = f"a file of one target {alone:.1f} s, {changed} of {len(made)} buckets tracked again"
    return f"added: {costs}; beside a run over all: {found}; {moved}; {single}"


def changed_by(earlier: pl.DataFrame, later: pl.DataFrame) -> str:
    """In words: how many of the earlier rows have another estimate since rows were added, and by how much."""
    names = ["file", "row", "x_sd"] + [name for name in ("x", "latitude") if name in earlier.columns]
    pair = earlier.select(names).join(later.select(names), on=["file", "row"], how="left", suffix="_later")
    other = pair["x_sd"].ne_missing(pair["x_sd_later"]) | pair[names[-1]].ne_missing(pair[f"{names[-1]}_later"])
    size = (pair["x_sd_later"] / pair["x_sd"] - 1.0).abs().fill_null(0.0).to_numpy()
    return (
        f"{int(other.sum()):,} of {pair.height:,} earlier rows have another estimate, and an sd that differs by "
        f"{100.0 * float(np.median(size)):.2f} % in the median, by {100.0 * float(size.max()):.0f} % at most"
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
