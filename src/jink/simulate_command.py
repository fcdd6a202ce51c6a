"""`jink simulate`: check what was asked, simulate in pieces, write one table or nothing."""

from __future__ import annotations

import json
import sys
import tempfile
import time as clock
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from .io.errors import InputError


@dataclass(frozen=True)
class SimulateRequest:
    """What the command line asked for, as it came."""

    name: str
    runs: int
    seed: int
    output: str
    sensor: str | None
    interval: float | None
    jitter: float | None
    detection: float | None
    outliers: float | None
    bias: str | None
    kind: str
    json: bool
    quiet: bool


def run_simulate(request: SimulateRequest) -> int:
    """Exit status: 0 done, 1 a failure that is not the input's fault, 2 unusable input or request."""
    try:
        return _run(request)
    except ValueError as error:
        return _failed(request, str(error), 2)
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] not in ("polars", "narwhals", "pyproj"):
            raise
        return _failed(request, f'{error.name} is missing; pip install "jink[track]" brings it', 1)
    except MemoryError:
        return _failed(request, "not enough memory; simulate fewer runs", 1)
    except OSError as error:
        return _failed(request, f"{error.strerror or error}: {error.filename or ''}", 1)


def _run(request: SimulateRequest) -> int:
    from .io.writing import check_writable, format_of

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
    scenario = choose(request)
    rows = _write(scenario, request, output, kind)
    _say(request, scenario, rows, clock.perf_counter() - began)
    return 0


def choose(request: SimulateRequest) -> Any:
    """The scenario by name, or from a file of recorded tracks, seen as asked. Errors: ValueError."""
    from .scenarios import by_name

    path = Path(request.name)
    if path.suffix and path.is_file():
        from .scenarios.recorded import recorded

        chosen = recorded(path, kind=request.kind)
    elif "/" in request.name or path.suffix in (".parquet", ".csv", ".json", ".jsonl", ".arrow"):
        raise InputError(f"there is no file {request.name}")
    else:
        chosen = by_name(request.name)
    changes: dict[str, Any] = {"detection": request.detection, "outlier_share": request.outliers}
    changes = {name: value for name, value in changes.items() if value is not None}
    if request.sensor is not None or request.interval is not None or request.jitter is not None:
        seen = chosen.observation if request.sensor is None else _sensor(request.sensor)
        chosen = chosen.seen_by(seen, interval=request.interval, jitter=request.jitter)
    if request.bias is not None:
        changes["bias"] = _bias(request.bias)
    return replace(chosen, observation=replace(chosen.observation, **changes)) if changes else chosen


def _sensor(given: str) -> str | float:
    from .arguments import unknown
    from .scenarios import RADARS

    if given in RADARS:
        return given
    try:
        sd = float(given)
    except ValueError:
        raise InputError(unknown("sensor", given, RADARS) + ", or a position noise in metres") from None
    if not 0 < sd < float("inf"):
        raise InputError(f"--sensor is {given}; expected a position noise above 0 m, or a radar's name")
    return sd


def _bias(given: str) -> tuple[float, ...]:
    try:
        return tuple(float(item) for item in given.split(","))
    except ValueError:
        raise InputError(
            f"--bias is {given!r}; expected numbers with commas, one per component (m, rad, m/s)"
        ) from None


def _write(scenario: Any, request: SimulateRequest, output: Path, kind: str) -> int:
    """Pieces go to files beside the output and are joined in a stream: bounded memory. Returns rows."""
    import polars as pl

    from .io.writing import atomically, compress, write_tracks
    from .simulate import simulation_table

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
        "sensor": describe(scenario.observation),
        "written": [request.output],
        "seconds": seconds,
    }
    if request.json:
        sys.stdout.write(json.dumps(done, indent=2, ensure_ascii=False) + "\n")
    elif not request.quiet:
        sys.stdout.write(
            f"{scenario.name}: {scenario.summary}\n"
            f"{request.runs:,} runs of {scenario.schedule.count} scans, seed {request.seed}, {done['sensor']}\n"
            f"{rows:,} rows to {request.output} in {seconds:.1f} s\n"
        )


def describe(observation: Any) -> str:
    """A sensor in words: what it is and its noise, in SI units; what makes it worse than that."""
    sensor = observation.sensor
    noise = {name: value for name, value in vars(sensor).items() if name.endswith("sd") and value is not None}
    parts = [f"{name.removesuffix('_sd')} {value}" for name, value in noise.items()]
    words = f"{type(sensor).__name__.lower()}, sd " + ", ".join(parts).removeprefix("sd ")
    if observation.detection < 1:
        words += f", detection {observation.detection:g}"
    if observation.outlier_share:
        words += f", {observation.outlier_share:.1%} outliers"
    return words + (f", bias {tuple(observation.bias)}" if observation.bias else "")


def _failed(request: SimulateRequest, message: str, status: int) -> int:
    if request.json:
        sys.stdout.write(json.dumps({"error": message, "status": status}, ensure_ascii=False) + "\n")
    sys.stderr.write(f"jink: {message}\n")
    return status
