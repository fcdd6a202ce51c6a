"""What odd inputs cost: a fast pipe, many targets in it, a long line, archives, many columns, junk, packed output.

python -m benchmarks.hostile
"""

from __future__ import annotations

import gzip
import json
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import polars as pl

from jink.io.formats.csv import CsvText
from jink.io.formats.json import JsonText
from jink.io.packing import MEMBER
from jink.io.writing import write_packed, write_tracks

MEASURE = (
    "import resource, subprocess, sys; status = subprocess.call(sys.argv[2:], stdin=open(sys.argv[1], 'rb'), "
    "stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL); used = resource.getrusage(resource.RUSAGE_CHILDREN); "
    "print(status, used.ru_utime + used.ru_stime, used.ru_maxrss * 1024)"
)


def piped(path: Path) -> tuple[float, float]:
    """CPU seconds and peak bytes of `jink track -` on a file of lines."""
    command = [sys.executable, "-m", "jink", "track", "-", "--quiet"]
    done = subprocess.run([sys.executable, "-c", MEASURE, path, *command], check=True, capture_output=True, text=True)
    _, cpu, peak = map(float, done.stdout.split())
    return cpu, peak


def reports(path: Path, count: int, targets: int, geographic: bool) -> None:
    """Reports of aircraft that take turns, every 4 s each."""
    rng = random.Random(1)
    places = [(rng.uniform(45, 55), rng.uniform(5, 15), rng.uniform(-1, 1), rng.uniform(-1, 1)) for _ in range(targets)]
    with path.open("w", encoding="utf-8") as handle:
        for k in range(count):
            north, east, up, right = places[k % targets]
            s = 4.0 * (k // targets)
            row: dict[str, object] = {"hex": f"{k % targets:06x}", "t": 1.7e9 + s + 4.0 * (k % targets) / targets}
            if geographic:
                row |= {
                    "lat": round(north + s * up / 555, 6),
                    "lon": round(east + s * right / 375, 6),
                    "alt_baro": 31_000,
                }
            else:
                row |= {"x": round(200 * s * right + rng.gauss(0, 20), 2), "y": round(200 * s * up, 2)}
            handle.write(json.dumps(row) + "\n")


def seconds(work: Callable[[], object]) -> float:
    """The least CPU time of three."""
    out = []
    for _ in range(3):
        began = time.process_time()
        work()
        out.append(time.process_time() - began)
    return min(out)


def pipes(folder: Path) -> None:
    """Lines per second of CPU, memory per target, and a long line."""
    path = folder / "lines.jsonl"
    path.write_text('{"hex": "a", "t": 1.7e9, "x": 0.0, "y": 0.0}\n', encoding="utf-8")
    start, least = piped(path)
    for name, geographic in (("x and y", False), ("latitude and longitude", True)):
        reports(path, 200_000, 1_000, geographic)
        print(f"pipe, {name}: {200_000 / (piped(path)[0] - start):,.0f} lines per second of CPU", flush=True)
    reports(path, 300_000, 100_000, False)
    print(f"pipe, 100,000 targets: {(piped(path)[1] - least) / 1e5 / 1e3:.1f} kB each", flush=True)
    reports(path, 1_000, 10, False)
    short = piped(path)[0]
    with path.open("a", encoding="utf-8") as handle:
        handle.write('{"hex": "' + "a" * 40_000_000 + '"}\n')
    print(f"pipe, a line of 40 MB: {piped(path)[0] - short:.2f} s more", flush=True)


def archives(folder: Path) -> None:
    """Gigabytes of zeros in a small file."""
    bomb = folder / "bomb.csv.gz"
    with gzip.open(bomb, "wb", compresslevel=9) as handle:
        for _ in range(20_000):
            handle.write(bytes(1_000_000))
    began = time.perf_counter()
    done = subprocess.run([sys.executable, "-m", "jink", "track", bomb], capture_output=True, text=True, check=False)
    print(
        f"20 GB in {bomb.stat().st_size / 1e6:.1f} MB: status {done.returncode}, {time.perf_counter() - began:.1f} s, "
        f"{done.stderr.strip().removeprefix('jink: ').replace(str(folder), '')!r}",
        flush=True,
    )


def texts() -> None:
    """Many columns, and one line that is no JSON."""
    names = ["target", "time", "x", "y", *(f"n{k}" for k in range(60_000))]
    wide = (",".join(names) + "\n" + "\n".join(",".join(["1"] * len(names)) for _ in range(3))).encode()
    print(f"60,000 columns: {seconds(lambda: CsvText('f', wide).read(names[:4])):.2f} s of CPU", flush=True)
    lines = [json.dumps({"id": f"t{k % 9}", "time": k * 0.5, "x": k * 1.1, "y": k * 0.3}) for k in range(400_000)]
    clean = "\n".join(lines).encode()
    lines[222_222] = "{broken"
    junk = "\n".join(lines).encode()
    one, other = (
        seconds(lambda text=text: JsonText("f", text).read(["id", "time", "x", "y"])) for text in (clean, junk)
    )
    print(f"one junk line in 400,000 of JSON: {other / one:.2f} times the CPU", flush=True)


def packed(folder: Path) -> None:
    """Tracks as .csv.gz beside Parquet."""
    rng = np.random.default_rng(0)
    columns = {f"c{k}": rng.normal(size=200_000) for k in range(30)}
    table = pl.DataFrame({"time": pl.Series(range(200_000)).cast(pl.Datetime("us", "UTC")), **columns})
    path = folder / "t"

    parquet = seconds(lambda: write_tracks(table, path, "parquet"))
    text = seconds(lambda: write_tracks(table, path, "csv"))
    csv = seconds(lambda: write_packed(table, path, "csv"))
    print(
        f".csv.gz of 200,000 rows: {csv:.2f} s of CPU on all cores, Parquet {parquet:.2f} s "
        f"({csv / parquet:.1f} times), the text alone {text:.2f} s ({text / parquet:.1f} times)",
        flush=True,
    )
    try:
        from isal import isal_zlib
    except ImportError:
        print("(packed by ISA-L: pip install isal)")
        return
    write_tracks(table, path, "csv")
    content = path.read_bytes()

    def by_isal() -> None:
        for k in range(0, len(content), MEMBER):
            member = isal_zlib.compressobj(2, wbits=31)
            member.compress(content[k : k + MEMBER])
            member.flush()

    print(f"the text, packed by ISA-L, which jink does not use: {(text + seconds(by_isal)) / parquet:.1f} times")


def main() -> None:
    """Print a line for each."""
    with tempfile.TemporaryDirectory() as name:
        pipes(Path(name))
        archives(Path(name))
        texts()
        packed(Path(name))


if __name__ == "__main__":
    main()
