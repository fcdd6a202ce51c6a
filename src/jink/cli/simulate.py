"""`jink simulate`: check the request, simulate in pieces, write one table or nothing."""

from __future__ import annotations

import sys
import time as clock
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from ..frozen import frozen
from ..io.errors import InputError
from .exit_status import exit_status
from .request import (
    FLAG,
    RecordedKind,
    Runs,
    SafeCsv,
    Seed,
    SensorOptions,
    check_at_least,
    check_kind,
    check_seed,
    completed_from,
    json_text,
    say,
)


@frozen(kw_only=True)
class SimulateRequest(SensorOptions):
    """Simulate a scenario and write measurements and truth as one table.

    Both jink track and jink compare can read the table.
    """

    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME",
            show_default=False,
            help="A scenario, such as lee-2003, random-turns or terminal-area (a wrong name lists all), "
            "or a whole sky of plots without identity, such as sky-regional. "
            "Or a file of recorded positions: its smoothed tracks become the truth.",
            autocompletion=completed_from("scenarios"),
        ),
    ]
    output: Annotated[
        str,
        typer.Option("--output", "-o", metavar="FILE", help="Where the table goes: .parquet, .csv, .jsonl or .arrow."),
    ]
    runs: Runs = 100
    seed: Seed = 0
    kind: RecordedKind = "aircraft"
    json: Annotated[bool, typer.Option("--json", help="Print the summary as JSON.", **FLAG)] = False
    safe_csv: SafeCsv = False
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print no summary.", **FLAG)] = False


def run_simulate(request: SimulateRequest) -> int:
    """Exit status: 0 done, 1 a failure that is not the input's fault, 2 unusable input or request."""
    return exit_status(lambda: _run(request), memory="not enough memory; simulate fewer runs", as_json=request.json)


def _run(request: SimulateRequest) -> int:
    from ..io.spreadsheets import check_is_csv
    from ..io.writing import MAPS, check_writable, format_of

    began = clock.perf_counter()
    check_at_least(1, runs=request.runs)
    check_seed(request.seed)
    check_kind(request.kind)
    output = Path(request.output)
    file_format = format_of(output)
    if file_format in MAPS:
        raise InputError(
            f"the output {output} cannot be {MAPS[file_format]}: scenarios have no place on a map; "
            "write to .parquet or .csv"
        )
    if request.safe_csv:
        check_is_csv(output, file_format)
    check_writable(output)
    if output.exists() and Path(request.name).exists() and output.samefile(request.name):
        raise InputError(f"{output} is an input; the output needs another name")
    if request.name.startswith("sky-"):
        return _run_sky(request, output, file_format, began)
    scenario = request.scenario_called(request.name, request.kind)
    rows = _write(scenario, request, output, file_format)
    _say(request, scenario, rows, clock.perf_counter() - began)
    return 0


def _run_sky(request: SimulateRequest, output: Path, file_format: str, began: float) -> int:
    """Plots without identity, and what was there in a table beside them: `sky.parquet`, `sky.truth.parquet`."""
    from ..io.spreadsheets import harmless
    from ..io.writing import atomically, compress, write_tracks
    from ..scenarios.skies import sky_called
    from ..scenarios.table import sky_tables

    if request.sensor_options:
        raise InputError(f"{request.name} is a whole sky, seen by its own sensor; it takes no options of the sensor")
    sky = sky_called(request.name)
    plots, truth = sky_tables(sky, request.runs, request.seed)
    beside = output.with_name(f"{output.name.removesuffix(''.join(output.suffixes))}.truth.parquet")
    with atomically(output, beside) as (first, second):
        write_tracks(harmless(plots) if request.safe_csv else plots, first, file_format)
        if output.suffix == ".gz":
            compress(first, file_format)
        truth.write_parquet(second)
    done = {
        "scenario": sky.name,
        "summary": sky.summary,
        "runs": request.runs,
        "seed": request.seed,
        "rows": plots.height,
        "sensor": f"position {sky.sd:.3g} m, detected with {sky.detection:g}, {sky.clutter:g} false plots a scan",
        "written": [str(output), str(beside)],
        "seconds": clock.perf_counter() - began,
    }
    if request.json:
        sys.stdout.write(json_text(done, allow_nan=True))
    elif not request.quiet:
        say(
            f"{sky.name}: {sky.summary}\n"
            f"{request.runs:,} runs, seed {request.seed}, {done['sensor']}\n"
            f"{plots.height:,} plots to {output}, the truth to {beside} in {done['seconds']:.1f} s\n"
        )
    return 0


def _write(scenario: Any, request: SimulateRequest, output: Path, file_format: str) -> int:
    """Write pieces to files beside the output and join them in a stream, so memory is bounded. Returns rows."""
    import polars as pl

    from ..io.spreadsheets import harmless
    from ..io.temporary import folder_in
    from ..io.writing import atomically, compress, write_tracks
    from ..scenarios.table import simulation_table

    pieces = scenario.chunks(request.runs, request.seed)
    tables: Iterator[pl.DataFrame] = (simulation_table(piece) for piece in pieces)
    if request.safe_csv:
        tables = map(harmless, tables)
    with (
        atomically(output) as (temporary,),
        folder_in(output.parent) as folder,
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
            write_tracks(first, temporary, file_format)
        else:
            del first
            _join(pl.scan_parquet(sorted(Path(folder).iterdir())), temporary, file_format)
        if output.suffix == ".gz":
            compress(temporary, file_format)
    return rows


def _join(table: Any, path: Path, file_format: str) -> None:
    if file_format == "parquet":
        table.sink_parquet(path, compression="zstd", compression_level=1)
    elif file_format == "arrow":
        table.sink_ipc(path)
    elif file_format == "csv":
        table.sink_csv(path)
    else:
        table.sink_ndjson(path)


def _say(request: SimulateRequest, scenario: Any, rows: int, seconds: float) -> None:
    from ..scenarios.observation import in_words

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
        sys.stdout.write(json_text(done, allow_nan=True))
    elif not request.quiet:
        say(
            f"{scenario.name}: {scenario.summary}\n"
            f"{request.runs:,} runs, seed {request.seed}, {done['sensor']}\n"
            f"{rows:,} rows to {request.output} in {seconds:.1f} s\n"
        )
