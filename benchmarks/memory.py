"""Peak memory of `jink track --memory 2GB`: many targets, and one long target smoothed.

    python -m benchmarks.memory                     10^7 rows, and one target of 5*10^6 rows, smoothed
    python -m benchmarks.memory 10000000 50000000   these numbers of rows, 2,000 for each target

The tracks of the first number of rows in memory are compared with those of --memory, and with those of the same targets
among more rows. The noise of these is that of a sample of other targets.
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


def compared(some: Path, more: Path) -> str:
    """How far apart two files of tracks are, read in slices, where both have the same targets."""
    count = pl.scan_parquet(some).select(pl.len()).collect().item()
    same, most = True, 0.0
    for k in range(0, count, 1_000_000):
        one, other = (pl.scan_parquet(path).slice(k, min(1_000_000, count - k)).collect() for path in (some, more))
        if not one["target"].equals(other["target"]):
            return "other targets"
        same &= one.equals(other)
        for name in ("x", "y", "z"):
            apart = np.abs((one[name] - other[name]).to_numpy() / one[f"{name}_sd"].to_numpy())
            most = max(most, float(np.nanmax(apart)))
    return "the same tracks, bit by bit" if same else f"positions at most {most:.2g} sds apart"


def report(name: str, figures: tuple[float, float, float], more: str = "") -> None:
    """One line."""
    wall, cpu, peak = figures
    print(f"{name:>34}  peak {peak / 1e9:5.2f} GB  wall {wall:6.1f} s  CPU {cpu:6.1f} s  {more}", flush=True)


def main() -> None:
    """Print one line for each table."""
    sizes = [int(word) for word in sys.argv[1:]] or [10_000_000]
    with tempfile.TemporaryDirectory() as folder:
        source, output, first = (Path(folder, name) for name in ("in.parquet", "out.parquet", "first.parquet"))
        write_stream(tables(LONG, LONG), source, "parquet")
        report(f"one target of {LONG:,} rows, smoothed", tracked(source, output, "--smooth", "--memory", MEMORY))
        for number, rows in enumerate(sizes):
            write_stream(tables(rows, EACH), source, "parquet")
            bounded = tracked(source, output, "--memory", MEMORY)
            if number == 0:
                report(f"{rows:,} rows in memory", tracked(source, first, "--memory", "1TB"))
            report(f"{rows:,} rows, --memory {MEMORY}", bounded, compared(first, output))


if __name__ == "__main__":
    main()
