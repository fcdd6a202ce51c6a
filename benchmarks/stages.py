"""What `jink track` costs a row, stage by stage, from file to file: Parquet, CSV and JSON Lines, in and out."""

from __future__ import annotations

import json
import resource
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .commands import installed_environment
from .targets import Row

FLIGHTS = Path(__file__).parents[1] / "examples" / "flights.parquet"
COPIES = 8  # of the example's flights: some 335,000 rows
BESIDES = ("read", "recognise", "clean", "place", "write")  # what is neither noise, nor filter, nor the table it makes
LIMITS = {"parquet": 2.5, "csv": 5.0, "jsonl": 5.0}  # µs of CPU a row for these together
START = "start and end"  # of the process, outside of what `--timings` shows
WHOLE = {"parquet": 5.0, "parquet, smoothed": 8.0}  # and for all, process start included


def measure(rounds: int, copies: int = COPIES) -> dict[str, Any]:
    """Seconds of CPU a row by stage, of every round, by format; smoothed as well."""
    found: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        files = _files(Path(folder), copies)
        _once(FLIGHTS, Path(folder))  # which compiles its modules
        for _ in range(rounds):
            for name, path in files.items():
                found.setdefault(name, []).append(_once(path, Path(folder)))
            found.setdefault("parquet, smoothed", []).append(_once(files["parquet"], Path(folder), "--smooth"))
    return found


def _files(folder: Path, copies: int) -> dict[str, Path]:
    import polars as pl

    flights = pl.read_parquet(FLIGHTS)
    many = pl.concat(
        flights.with_columns(pl.format("{}-{}", "icao24", pl.lit(k)).alias("icao24")) for k in range(copies)
    )
    paths = {name: folder / f"in.{name}" for name in LIMITS}
    many.write_parquet(paths["parquet"])
    many.write_csv(paths["csv"])
    many.write_ndjson(paths["jsonl"])
    return paths


def _once(path: Path, folder: Path, *more: str) -> dict[str, float]:
    """µs of CPU a row of each stage, and of what Python takes before and after them."""
    command = [sys.executable, "-m", "jink", "track", str(path), "-o", str(folder / f"out{path.suffix}")]
    command += ["--json", "--timings", *more]
    before = _of_children()
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=installed_environment())
    whole, summary = _of_children() - before, json.loads(done.stdout)
    stages = {name: figure["cpu"] for name, figure in summary["timings"].items()}
    stages[START] = whole - sum(stages.values())
    return {name: 1e6 * seconds / summary["rows"] for name, seconds in stages.items()}


def _of_children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def rows(found: dict[str, Sequence[dict[str, float]]]) -> list[Row]:
    """For each format what reading, cleaning, placing and writing take together, and all stages one by one."""
    out = []
    for name, limit in LIMITS.items():
        if name not in found:
            continue
        stages = {stage: statistics.median(once[stage] for once in found[name]) for stage in found[name][0]}
        besides = statistics.median(sum(once[stage] for stage in BESIDES) for once in found[name])
        each = ", ".join(f"{stage} {cost:.2f}" for stage, cost in stages.items())
        what = f"`jink track`, {name} in and out: {', '.join(BESIDES)}"
        out.append(Row(what, f"{besides:.2f} µs of CPU a row; {each}", f"≤ {limit:g} µs", besides <= limit))
    for name, limit in WHOLE.items():
        if name in found:
            whole = statistics.median(sum(once.values()) for once in found[name])
            what = f"`jink track`, {name}, process start included"
            out.append(Row(what, f"{whole:.2f} µs of CPU a row", f"≤ {limit:g} µs", whole <= limit))
    return out
