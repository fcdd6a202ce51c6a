"""`jink simulate`: check what was asked, simulate in pieces, write one table or nothing."""

from __future__ import annotations

import json
import sys
import tempfile
import time as clock
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..io.errors import InputError
from ..scenarios.observation import Seeing, in_words
from .exit_status import exit_status


@dataclass(frozen=True)
class SimulateRequest:
    """What the command line asked for, as it came."""

    name: str
    runs: int
    seed: int
    output: str
    seeing: Seeing
    kind: str
    json: bool
    quiet: bool


def run_simulate(request: SimulateRequest) -> int:
    """Exit status: 0 done, 1 a failure that is not the input's fault, 2 unusable input or request."""
    return exit_status(
        lambda: _run(request), memory="not enough memory; simulate fewer runs", as_json=request.json
    )


def _run(request: SimulateRequest) -> int:
    from ..io.writing import check_writable, format_of

    began = clock.perf_counter()
    if request.runs < 1:
        raise InputError(f"--runs is {request.runs}; expected at least 1")
    if request.seed < 0:
        raise InputError(f"--seed is {request.seed}; expected a whole number from 0")
    output = Path(request.output)
    kind = format_of(output)
    if kind == "geojson":
        raise InputError(
            f"the output {output} cannot be GeoJSON: scenarios are on no map; write to .parquet or .csv"
        )
    check_writable(output)
    if output.exists() and Path(request.name).exists() and output.samefile(request.name):
        raise InputError(f"{output} is an input; the output needs another name")
    scenario = choose(request.name, request.kind, request.seeing)
    rows = _write(scenario, request, output, kind)
    _say(request, scenario, rows, clock.perf_counter() - began)
    return 0


def choose(name: str, kind: str, seeing: Seeing) -> Any:
    """The scenario by name, or from a file of recorded tracks, seen as asked. Errors: ValueError."""
    from ..scenarios import by_name

    path = Path(name)
    if path.suffix and path.is_file():
        from ..scenarios.recorded import recorded

        return seeing.of(recorded(path, kind=kind))
    if "/" in name or path.suffix in (".parquet", ".csv", ".json", ".jsonl", ".arrow"):
        raise InputError(f"there is no file {name}")
    return seeing.of(by_name(name))


def _write(scenario: Any, request: SimulateRequest, output: Path, kind: str) -> int:
    """Pieces go to files beside the output and are joined in a stream: bounded memory. Returns rows."""
    import polars as pl

    from ..io.writing import atomically, compress, write_tracks
    from ..scenarios.table import simulation_table

    tables: Iterator[pl.DataFrame] = (
        simulation_table(piece) for piece in scenario.chunks(request.runs, request.seed)
    )
    with (
        atomically(output) as (temporary,),
        tempfile.TemporaryDirectory(dir=output.parent, prefix=".jink.") as folder,
    ):
        first = next(tables)
        rows, parts = first.height, 0
        for table in tables:
            if parts == 0:
                first.write_parquet(Path(folder, "000000.parquet"))
            parts += 1
            rows += table.height
            table.write_parquet(Path(folder, f"{parts:06d}.parquet"))
        if parts == 0:
            write_tracks(first, temporary, kind)
        else:
            del first
            _join(pl.scan_parquet(sorted(Path(folder).iterdir())), temporary, kind)
        if output.suffix == ".gz":
            compress(temporary)
    return rows


def _join(table: Any, path: Path, kind: str) -> None:
    if kind == "parquet":
        table.sink_parquet(path, compression="zstd", compression_level=1)
    elif kind == "arrow":
        table.sink_ipc(path)
    elif kind == "csv":
        table.sink_csv(path)
    else:
        table.sink_ndjson(path)


def _say(request: SimulateRequest, scenario: Any, rows: int, seconds: float) -> None:
    done = {
        "scenario": scenario.name,
        "summary": scenario.summary,
        "runs": request.runs,
        "seed": request.seed,
        "rows": rows,
        "sensor": in_words(scenario),
        "written": [request.output],
        "seconds": seconds,
    }
    if request.json:
        sys.stdout.write(json.dumps(done, indent=2, ensure_ascii=False) + "\n")
    elif not request.quiet:
        sys.stdout.write(
            f"{scenario.name}: {scenario.summary}\n"
            f"{request.runs:,} runs, seed {request.seed}, {done['sensor']}\n"
            f"{rows:,} rows to {request.output} in {seconds:.1f} s\n"
        )
