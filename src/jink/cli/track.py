"""`jink track`: check what was asked, run it with a progress bar, write all or nothing, say what was done."""

from __future__ import annotations

import json
import math
import sys
import time as clock
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..io.errors import InputError
from .exit_status import exit_status


@dataclass(frozen=True)
class Request:
    """What the command line asked for, as it came."""

    inputs: list[str]
    output: str | None
    report: str | None
    smooth: bool
    kind: str
    filter: str | None
    sensor_sd: str | None
    site: str | None
    columns: list[str]
    altitude_unit: str | None
    time_unit: str | None
    gap: float | None
    min_points: int
    sort: bool
    drop_duplicates: bool
    drop_stale: bool
    check_coordinates: bool
    threads: int | None
    json: bool
    quiet: bool


def run_command(request: Request) -> int:
    """Exit status: 0 done, 1 a failure that is not the input's fault, 2 unusable input or request."""
    return exit_status(
        lambda: _run(request), mistakes=InputError, memory="not enough memory; track fewer files at once", as_json=request.json
    )  # fmt: skip


def _run(request: Request) -> int:
    if "-" in request.inputs:
        from .live import run_live

        return run_live(request)
    return _run_files(request)


def parse_columns(given: list[str]) -> dict[str, str]:
    """`target=hex,time_ms=t` (also repeated) to role and column name."""
    pairs: dict[str, str] = {}
    for item in ",".join(given).split(",") if given else []:
        role, equals, name = item.partition("=")
        if not equals or not role.strip() or not name.strip():
            raise InputError(
                f"--columns: {item!r} is not ROLE=COLUMN, for example target=hex,altitude_ft=alt"
            )
        pairs[role.strip()] = name.strip()
    return pairs


def parse_site(given: str | None) -> tuple[float, ...] | None:
    """`48.1,11.6,520` to latitude, longitude (degrees) and altitude (m, 0 if left out)."""
    if given is None:
        return None
    try:
        values = tuple(float(item) for item in given.split(","))
    except ValueError:
        values = (math.nan, math.nan)
    if len(values) not in (2, 3) or not (abs(values[0]) <= 90.0 and abs(values[1]) <= 360.0):
        raise InputError(f"--site is {given!r}; expected LATITUDE,LONGITUDE[,ALTITUDE] (degrees, metres)")
    return values


def settings_of(request: Request) -> tuple[Any, Any]:
    """What reading and tracking need to know."""
    from ..catalogue.choose import load_filter
    from ..io.geodesy import SiteFrame
    from ..io.loading import Reading
    from ..tracking.batch import Settings
    from ..tracking.noise_level import parse_sensor_sd

    site = parse_site(request.site)
    settings = Settings(
        filter=load_filter(request.filter),
        kind=request.kind,
        smooth=request.smooth,
        sensor_sd=parse_sensor_sd(request.sensor_sd),
        site=SiteFrame(*site) if site else None,
        gap=request.gap,
        min_points=request.min_points,
        sort=request.sort,
        drop_duplicates=request.drop_duplicates,
        drop_stale=request.drop_stale,
        threads=request.threads,
    )
    reading = Reading(
        parse_columns(request.columns), request.altitude_unit, request.time_unit, request.check_coordinates
    )
    return reading, settings


def _run_files(request: Request) -> int:
    from ..io.files import expand
    from ..io.writing import check_writable, format_of

    began = clock.perf_counter()
    if not (request.output or request.report or request.json):
        raise InputError(
            "nothing to write: give -o tracks.parquet (or .csv, .jsonl, .geojson), --report page.html, "
            "or --json for the summary alone"
        )
    output = Path(request.output) if request.output else None
    report = Path(request.report) if request.report else None
    kind = format_of(output) if output else ""
    inputs = {path.resolve() for path in expand(request.inputs)}
    for path in filter(None, (output, report)):
        check_writable(path)
        if path.resolve() in inputs:
            raise InputError(f"{path} is an input; the output needs another name")
    reading, settings = settings_of(request)
    with _progress(request) as progress:
        from ..io.loading import load_files
        from ..tracking.batch import run

        loaded = load_files(request.inputs, reading, lambda done, total: progress("reading", done, total))
        if kind == "geojson" and loaded.measurements.position != "geographic" and settings.site is None:
            raise InputError(
                "GeoJSON needs places on the map: give --site LATITUDE,LONGITUDE for x, y or range, azimuth"
            )
        tracked = run(loaded, settings, progress)
        written = _write(tracked, output, kind, report, progress)
    tracked.summary["written"] = [str(path) for path in written]
    tracked.summary["seconds"] = clock.perf_counter() - began
    if request.json:
        sys.stdout.write(json.dumps(tracked.summary, indent=2, ensure_ascii=False, default=str) + "\n")
    elif not request.quiet:
        from ..report.summary_table import show

        show(tracked.summary)
    return 0


def _write(tracked: Any, output: Path | None, kind: str, report: Path | None, progress: Any) -> list[Path]:
    """All files or none: written under other names first, then renamed."""
    from ..io.writing import atomically, compress, write_tracks

    wanted = [path for path in (output, report) if path]
    if wanted:
        rejected = rejected_path(wanted[0])
        if tracked.rejected.height or rejected.exists():
            wanted.append(rejected)
    with atomically(*wanted) as temporary:
        for number, (path, name) in enumerate(zip(wanted, temporary, strict=True)):
            progress("writing", number, len(wanted))
            if path is output:
                write_tracks(tracked.tracks, name, kind)
                if path.suffix == ".gz":
                    compress(name)
            elif path is report:
                from ..report import write_report

                write_report(tracked.tracks, name, summary=tracked.summary)
            else:
                tracked.rejected.write_parquet(name)
    return wanted


def rejected_path(beside: Path) -> Path:
    """`tracks.parquet` and `tracks.csv.gz` to `tracks.rejected.parquet`."""
    stem = Path(beside.name.removesuffix(".gz")).stem
    return beside.with_name(f"{stem}.rejected.parquet")


@contextmanager
def _progress(request: Request) -> Iterator[Any]:
    """A bar on standard error, if that is a terminal and nobody wants silence."""
    if request.quiet or request.json or not sys.stderr.isatty():
        yield lambda stage, done, total: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

    bar = Progress(
        TextColumn("{task.description:<10}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        console=Console(stderr=True),
        transient=True,
    )
    with bar:
        tasks: dict[str, Any] = {}

        def step(stage: str, done: int, total: int) -> None:
            if stage not in tasks:
                tasks[stage] = bar.add_task(stage, total=total)
            bar.update(tasks[stage], completed=done, total=total)

        step("reading", 0, 1)
        yield step
