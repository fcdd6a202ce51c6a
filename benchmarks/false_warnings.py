"""Warnings that should not be: of the example flights, the quickstart collection, and simulated files of every kind.

    python -m benchmarks.false_warnings [traffic-2.13-py3-none-any.whl] [--runs 5]

Every file is tracked as its own kind, with noise estimated from it. The wheel is fetched once, 28 MB, where none is
given. Exit status 1 where anything is warned of.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

import polars as pl
from typer.testing import CliRunner

import jink
from benchmarks.commands import fetch_collection
from jink.cli.main import app
from jink.scenarios import SCENARIOS
from scripts.extract_flights import read

FLIGHTS = Path(__file__).parents[1] / "examples/flights.parquet"


def warned(data: str | pl.DataFrame, kind: str) -> list[str]:
    """The codes and sentences of the warnings."""
    found = jink.track(data, kind=kind, details=True).summary["warnings"]
    return [f"{warning['code']}: {warning['message']}" for warning in found]


def simulated(name: str, runs: int, folder: Path) -> list[str] | None:
    """The same of one scenario's file; None of one axis, which `jink track` does not read."""
    path = folder / f"{name}.parquet"
    done = CliRunner().invoke(app, ["simulate", name, "-o", str(path), "--runs", str(runs)])
    if done.exit_code:
        raise RuntimeError(done.output)
    if not {"y", "range"} & set(pl.read_parquet_schema(path)):
        return None
    return warned(str(path), SCENARIOS[name].kind)


def main() -> None:
    """Print one line per file, and what is warned of."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("source", type=Path, nargs="?")
    options.add_argument("--runs", type=int, default=5)
    given = options.parse_args()
    files = 0
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        jobs = [("example flights", lambda: warned(str(FLIGHTS), "aircraft"))]
        jobs.append(("quickstart collection", lambda: warned(read(given.source or fetch_collection()), "aircraft")))
        for name in SCENARIOS:
            jobs.append((name, lambda name=name: simulated(name, given.runs, Path(folder))))
        for name, job in jobs:
            said = job()
            if said is None:
                print(f"{name:28} not tracked: it has one axis")
                continue
            files, wrong = files + 1, wrong + bool(said)
            print(f"{name:28} {'no warning' if not said else ''}", flush=True)
            for line in said:
                print(f"    {line}", flush=True)
    print(f"{wrong} of {files} files with a warning")
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
