"""Peak memory of `jink track --memory 2GB`: many targets, and one long target smoothed.

    python -m benchmarks.memory                     10^7 rows, and one target of 5*10^6 rows, smoothed
    python -m benchmarks.memory 10000000 50000000   these numbers of rows, 2,000 for each target

The tracks of the first number of rows are compared with those of a run in memory.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import polars as pl

from jink.io.sinks import write_stream

EACH = 2_000  # rows of a target
LONG = 5_000_000
MEMORY = "2GB"


def tables(rows: int, each: int) -> Iterator[pl.DataFrame]:
    """Targets that turn at random, seen every second with an sd of 20 m."""
    for number in range(rows // each):
        rng = np.random.default_rng(number)
        turns = np.repeat(rng.choice([0.0, 0.02, -0.03], each // 50 + 1, p=[0.6, 0.2, 0.2]), 50)[:each]
        course = rng.uniform(0.0, 2.0 * np.pi) + np.cumsum(turns)
        path = np.cumsum(200.0 * np.array([np.sin(course), np.cos(course)]), axis=1) + rng.normal(0, 20.0, (2, each))
        height = 9_000.0 + rng.normal(0, 10.0, each)
        seconds = 1.7e9 + rng.integers(0, 5_000) + np.arange(each)
        yield pl.DataFrame({"icao24": f"{number:06x}", "time": seconds, "x": path[0], "y": path[1], "z": height})


def tracked(source: Path, output: Path, *options: str) -> tuple[float, float, float]:
    """Wall seconds, CPU seconds and peak bytes of one run, in a process of its own."""
    measure = (
        "import resource, subprocess, sys; status = subprocess.call(sys.argv[1:]); "
        "used = resource.getrusage(resource.RUSAGE_CHILDREN); "
        "print(used.ru_utime + used.ru_stime, used.ru_maxrss * 1024); sys.exit(status)"
    )
    command = [sys.executable, "-m", "jink", "track", str(source), "-o", str(output), "--quiet", *options]
    began = time.perf_counter()
    done = subprocess.run([sys.executable, "-c", measure, *command], check=True, capture_output=True, text=True)
    cpu, peak = map(float, done.stdout.split())
    return time.perf_counter() - began, cpu, peak


def alike(one: Path, other: Path) -> bool:
    """Whether two files of tracks are the same, bit by bit, read in slices."""
    count = pl.scan_parquet(one).select(pl.len()).collect().item()
    slices = [
        (pl.scan_parquet(path).slice(k, 1_000_000).collect() for path in (one, other))
        for k in range(0, count, 1_000_000)
    ]
    same = all(first.equals(second) for first, second in slices)
    return same and count == pl.scan_parquet(other).select(pl.len()).collect().item()


def report(name: str, figures: tuple[float, float, float], more: str = "") -> None:
    """One line."""
    wall, cpu, peak = figures
    print(f"{name:>34}  peak {peak / 1e9:5.2f} GB  wall {wall:6.1f} s  CPU {cpu:6.1f} s  {more}", flush=True)


def main() -> None:
    """Print one line for each table."""
    sizes = [int(word) for word in sys.argv[1:]] or [10_000_000]
    with tempfile.TemporaryDirectory() as folder:
        source, output, whole = (Path(folder, name) for name in ("in.parquet", "out.parquet", "whole.parquet"))
        write_stream(tables(LONG, LONG), source, "parquet")
        report(f"one target of {LONG:,} rows, smoothed", tracked(source, output, "--smooth", "--memory", MEMORY))
        for number, rows in enumerate(sizes):
            write_stream(tables(rows, EACH), source, "parquet")
            bounded = tracked(source, output, "--memory", MEMORY)
            said = ""
            if number == 0:
                in_memory = tracked(source, whole, "--memory", "1TB")
                said = f"same tracks: {alike(output, whole)}"
                report(f"{rows:,} rows in memory", in_memory)
                whole.unlink()
            report(f"{rows:,} rows, --memory {MEMORY}", bounded, said)


if __name__ == "__main__":
    main()
