"""`jink track FILES -o FOLDER/`: time per row and core, peak memory of each process, and kills at random moments.

python -m benchmarks.archive                    4 million rows, 24 files, 20,000 targets of which one is hot
python -m benchmarks.archive 4000000 40000000   these numbers of rows, one after the other
python -m benchmarks.archive --kills 20         kill -9 at as many random moments, and compare the bytes
python -m benchmarks.archive --dask             two workers of dask, then again with one killed in either stage
python -m benchmarks.archive --floor            what reading, filtering and writing the same rows cost, each alone
python -m benchmarks.archive --whole            whether the tracks are those of one table in memory
python -m benchmarks.archive --append           a file that is added later, and one of a single target
python -m benchmarks.archive --hot 0.2          the share of all rows that the hot target has
python -m benchmarks.archive --geographic       latitude and longitude instead of x and y
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import random
import shutil
import signal
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from .archive_floor import floor
from .archive_more import appended, at_once
from .archive_run import command, tracked

TARGETS, FILES, HOT = 20_000, 24, 0.02
STEP, DAY = 5.0, 86_400.0


def path_of(rng: np.random.Generator, rows: int, step: float) -> tuple[np.ndarray, np.ndarray]:
    """One target that turns at random at 200 m/s, seen with an sd of 20 m; (rows,), (rows,)."""
    each = 50
    turns = np.repeat(rng.choice([0.0, 0.02, -0.03], rows // each + 1, p=[0.6, 0.2, 0.2]), each)[:rows]
    course = rng.uniform(0.0, 2.0 * np.pi) + np.cumsum(turns * step)
    noise = rng.normal(0, 20.0, (2, rows))
    x, y = np.cumsum(200.0 * step * np.array([np.sin(course), np.cos(course)]), axis=1) + noise
    return x, y


def written(folder: Path, rows: int, geographic: bool, share: float = HOT) -> list[Path]:
    """Hourly files, each in the order of time. One target has a share of all rows, the others as many as each other."""
    hot = int(share * rows)
    each = (rows - hot) // (TARGETS - 1)
    hours: list[list[pl.DataFrame]] = [[] for _ in range(FILES)]
    for number in range(TARGETS):
        rng = np.random.default_rng(number)
        count = hot if number == 0 else each
        step = DAY / hot if number == 0 else STEP
        begin = 0.0 if number == 0 else rng.uniform(0.0, max(1.0, DAY - count * step))
        seconds = begin + step * np.arange(count)
        x, y = path_of(rng, count, step)
        if geographic:
            x, y = 11.0 + x / 75_000.0, 48.0 + y / 111_000.0
            x, y = (x + 180.0) % 360.0 - 180.0, np.clip(y, -80.0, 80.0)
        z = 9_000.0 + rng.normal(0, 10.0, count)
        cut = np.searchsorted(seconds, DAY / FILES * np.arange(FILES + 1))
        names = ("longitude", "latitude", "altitude_m") if geographic else ("x", "y", "z")
        for hour in np.flatnonzero(np.diff(cut)):
            part = slice(cut[hour], cut[hour + 1])
            columns = dict(zip(names, (x[part], y[part], z[part]), strict=True))
            frame = pl.DataFrame({"id": pl.repeat(number, len(z[part]), dtype=pl.UInt32, eager=True)})
            hours[hour].append(frame.with_columns(time=pl.Series(1.7e9 + seconds[part]), **columns))
    paths = []
    for hour, frames in enumerate(hours):
        table = pl.concat(frames).sort("time")
        frames.clear()
        name = pl.format("t{}", pl.col("id").cast(pl.String).str.zfill(6)).alias("icao24")
        paths.append(folder / f"hour{hour:02d}.parquet")
        table.select(name, pl.exclude("id")).write_parquet(paths[-1])
    return paths


def hash_of(folder: Path) -> str:
    """Of all tracks."""
    found = hashlib.sha256()
    for path in sorted(folder.glob("bucket=*/*")):
        found.update(path.relative_to(folder).as_posix().encode() + path.read_bytes())
    return found.hexdigest()


def names_of(output: Path) -> set[str]:
    """Of everything that a run leaves: the folder's files and folders, and what is beside it."""
    beside = output.parent.glob(f"{output.name}*")
    return {path.relative_to(output.parent).as_posix() for path in (*output.rglob("*"), *beside)}


def killed(files: list[Path], output: Path, times: int, seconds: float) -> str:
    """Kill a run at random moments of all that it takes, run it again until it is through; says what was found."""
    rng, wanted = random.Random(1), hash_of(output)
    kept = names_of(output)
    same = orphans = 0
    for number in range(times):
        shutil.rmtree(output)
        Path(f"{output}.rejected.parquet").unlink(missing_ok=True)
        process = subprocess.Popen(command(files, output), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(rng.uniform(0.02, 0.98) * seconds)
        process.send_signal(signal.SIGKILL)
        process.wait()
        subprocess.run(command(files, output), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
        same += hash_of(output) == wanted
        other = names_of(output) ^ kept
        orphans += bool(other)
        named = f": {', '.join(sorted(other))}" if other else ""
        print(
            f"  kill {number + 1:>2}: same bytes {same} of {number + 1}, files too many or too few {orphans}{named}",
            flush=True,
        )
    return f"{times} kills: same bytes {same} times, files too many or too few {orphans} times"


def on_dask(files: list[Path], output: Path, wanted: str) -> str:
    """Two workers of dask without and with kills; says whether the bytes are those of processes, and the ratio."""
    from distributed import LocalCluster

    os.environ["POLARS_MAX_THREADS"] = "1"
    seconds, same = [], []
    for kill in (False, True):
        with LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None) as cluster:
            shutil.rmtree(output, ignore_errors=True)
            seconds.append(clustered([*command(files, output), "--cluster", cluster.scheduler_address], cluster, kill))
        same.append(hash_of(output) == wanted)
    return (
        f"dask: {seconds[0]:.1f} s; with a worker killed in either stage {seconds[1]:.1f} s, "
        f"{seconds[1] / seconds[0]:.2f} times as long; same bytes {sum(same)} of 2"
    )


def clustered(words: list[str], cluster: Any, kill: bool) -> float:
    """Wall seconds of a run; kill: a worker ends by `kill -9` when a third of each stage is done."""
    began = time.perf_counter()
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    left = {"map", "reduce"} if kill else set()
    for line in process.stderr:
        event = json.loads(line)
        if event["event"] in left and 3 * event["done"] >= event["of"]:
            left.remove(event["event"])
            os.kill(next(iter(cluster.workers.values())).pid, signal.SIGKILL)
    if process.wait() or left:
        raise RuntimeError(f"the run ended with {process.returncode}, without a kill in: {left}")
    return time.perf_counter() - began


def main() -> None:
    """Print one line for each number of rows."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rows", nargs="*", type=int, default=[4_000_000])
    parser.add_argument("--kills", type=int, default=0)
    parser.add_argument("--dask", action="store_true")
    for name in ("--floor", "--whole", "--append"):
        parser.add_argument(name, action="store_true")
    parser.add_argument("--hot", type=float, default=HOT)
    parser.add_argument("--geographic", action="store_true")
    options = parser.parse_args()
    cores = len(os.sched_getaffinity(0))
    for rows in options.rows:
        with tempfile.TemporaryDirectory() as folder:
            files = written(Path(folder), rows, options.geographic, options.hot)
            size = sum(path.stat().st_size for path in files)
            output = Path(folder, "tracks")
            done = tracked(files, output)
            peaks = ", ".join(f"{peak / 1e9:.2f}" for peak in done["peaks"])
            made = sum(path.stat().st_size for path in output.rglob("bucket=*/*"))
            slices = sum(path.stat().st_size for path in output.rglob(".jink/map/*"))
            count, cpu = done["rows"], done["cpu"]
            print(f"{count:,} rows: {size / 1e9:.2f} GB in, {slices / 1e9:.2f} GB slices, {made / 1e9:.2f} GB out")
            print(f"  wall {done['wall']:.1f} s, divided after {done['stages']['map']:.1f} s; CPU {cpu:.1f} s")
            print(f"  {cpu / count * 1e6:.2f} us of CPU a row, {done['map_cpu'] / count * 1e6:.2f} of it to divide")
            print(
                f"  wall times {cores} cores {done['wall'] * cores / count * 1e6:.2f} us a row; peaks {peaks} GB",
                flush=True,
            )
            if options.floor:
                print(f"  {floor(files, output)}", flush=True)
            if options.whole:
                print(f"  {at_once(files, output)}", flush=True)
            if options.append:
                print(f"  {appended(files, output)}", flush=True)
            if options.kills:
                print(killed(files, output, options.kills, done["wall"]), flush=True)
            if options.dask:
                print(on_dask(files, output, hash_of(output)), flush=True)


if __name__ == "__main__":
    main()
