"""`jink track`: check the request, track files with a progress bar or lines as they come, say what was done."""

from __future__ import annotations

import json
import os
import sys
import time as clock
from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from ..frozen import frozen
from ..io import ahead
from ..io.errors import InputError
from ..io.printable import printable
from .exit_status import PACKAGES, exit_status
from .request import (
    FLAG,
    SafeCsv,
    TilesOption,
    check_kind,
    check_tiles,
    completed_from,
    json_text,
    parse_columns,
    parse_sites,
    words_of,
)

OUTPUT, INPUT, CLEANING = "Output", "Input", "Cleaning (each step is on unless you switch it off)"
PLOTS = "Plots without identity"
ARCHIVE = "Archives (-o FOLDER/)"


class AltitudeUnit(StrEnum):
    """Unit of an altitude whose column name does not say."""

    ft = "ft"
    m = "m"


class TimeUnit(StrEnum):
    """Unit of numeric times whose column name does not say."""

    s = "s"
    ms = "ms"
    us = "us"
    ns = "ns"


class Axes(StrEnum):
    """Directions of x, y and z."""

    enu = "enu"
    ned = "ned"


class AzimuthFrom(StrEnum):
    """Where azimuth is 0, and with it which way it counts."""

    north = "north"
    east = "east"
    grid = "grid"


@frozen(kw_only=True)
class TrackRequest:
    """Turn position reports into tracks: clean them, estimate their noise, filter or smooth them.

    Rows that are in no track go to *.rejected.parquet beside the output, with file, row and reason.
    """

    inputs: Annotated[
        list[str],
        typer.Argument(
            metavar="INPUT",
            show_default=False,
            help="Files or quoted patterns: tables (CSV, Parquet, Arrow, JSON, JSON Lines) or formats of ADS-B, AIS "
            "and GPS, also as .gz or .zst. "
            "With '-', jink reads JSON Lines from standard input and writes each estimate at once.",
        ),
    ]
    output: Annotated[
        str | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            rich_help_panel=OUTPUT,
            help="Write the tracks: .parquet, .csv, .jsonl, .geojson, .gpx, .kml or .arrow; '-' writes JSON Lines to "
            "standard output; FOLDER/ or a URL takes an archive of any size. "
            "Without any output, the summary and the first tracks are shown.",
        ),
    ] = None
    append: Annotated[
        bool,
        typer.Option("--append", rich_help_panel=ARCHIVE, help="Add files to a folder that is there.", **FLAG),
    ] = False
    strict: Annotated[
        bool,
        typer.Option(
            "--strict",
            rich_help_panel=ARCHIVE,
            help="Stop at a file that cannot be read. Default: it is left out, and named among the rejected rows.",
            **FLAG,
        ),
    ] = False
    cluster: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS",
            rich_help_panel=ARCHIVE,
            help="Use the workers of a dask scheduler, such as tcp://host:8786, which see the same files.",
        ),
    ] = None
    keep: Annotated[
        list[str] | None,
        typer.Option(
            metavar="COLUMNS",
            rich_help_panel=OUTPUT,
            help="Columns of the input that go through to the output, such as callsign,sog. "
            "Default: those that say who a target is.",
        ),
    ] = None
    every: Annotated[
        str | None,
        typer.Option(
            metavar="TIME",
            rich_help_panel=OUTPUT,
            help="Write one row at each multiple of a time, such as 1s; "
            "between measurements it is predicted, with its sd.",
        ),
    ] = None
    report: Annotated[
        str | None,
        typer.Option(metavar="FILE", rich_help_panel=OUTPUT, help="Write one HTML page that shows the tracks."),
    ] = None
    tiles: TilesOption = None
    safe_csv: SafeCsv = False
    json: Annotated[bool, typer.Option("--json", rich_help_panel=OUTPUT, help="Print the summary as JSON.", **FLAG)] = (
        False
    )
    quiet: Annotated[
        bool,
        typer.Option("--quiet", "-q", rich_help_panel=OUTPUT, help="Print no progress and no summary.", **FLAG),
    ] = False
    timings: Annotated[
        bool,
        typer.Option(
            "--timings", rich_help_panel=OUTPUT, help="Say how long each stage took, on standard error.", **FLAG
        ),
    ] = False
    smooth: Annotated[
        bool,
        typer.Option(
            "--smooth", "-s", help="Use the whole track for every estimate, not only what came before it.", **FLAG
        ),
    ] = False
    lag: Annotated[
        str | None,
        typer.Option(
            metavar="LAG",
            help="Let every estimate use what was measured up to so many scans (2) or seconds (8s) later. "
            "One scan makes positions a fifth to a quarter better. A stream gets it beside the current estimate.",
        ),
    ] = None
    target_height: Annotated[
        str | None,
        typer.Option(
            "--target-height",
            metavar="M,SD",
            help="How high targets are above a radar that measures no heights, in metres, such as 3000,2500; "
            "ground: its ranges are those along the ground.",
        ),
    ] = None
    manoeuvre_g: Annotated[
        float | None,
        typer.Option(
            "--manoeuvre-g",
            metavar="G",
            help="Acceleration in g from which on a target manoeuvres, horizontally and vertically. "
            "Default: that of the kind, such as 0.05 and 0.03 for aircraft.",
        ),
    ] = None
    kind: Annotated[
        str,
        typer.Option(
            metavar="KIND",
            help="What the targets are: {kinds}. It decides the default filter and the default gap.",
            autocompletion=completed_from("kinds"),
        ),
    ] = "aircraft"
    filter: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="A filter's name (a wrong one lists all) or a file written by save(). Default: imm-corrected for "
            "aircraft and fighters, imm for others and for all that is smoothed, lagged or without names.",
            autocompletion=completed_from("filters"),
        ),
    ] = None
    sensor_sd: Annotated[
        str | None,
        typer.Option(
            metavar="SD",
            help="Noise of the measurements: 25 (metres), position=25,altitude=10 or range=50,azimuth_deg=0.1; "
            "also velocity, vertical_rate and range_rate (m/s). "
            "Default: from columns of ADS-B accuracy, or else estimated from the data.",
        ),
    ] = None
    no_velocity: Annotated[
        bool,
        typer.Option(
            "--no-velocity",
            help="Leave out reported speeds, courses, vertical rates and range rates. "
            "Default: used where they make held-out positions likelier.",
            **FLAG,
        ),
    ] = False
    threads: Annotated[int | None, typer.Option(metavar="N", help="Number of threads. Default: all cores.")] = None
    memory: Annotated[
        str | None,
        typer.Option(
            metavar="SIZE",
            help="How much memory may be used, such as 2GB; larger tables are tracked share by share. "
            "Default: a quarter of the machine's.",
        ),
    ] = None
    columns: Annotated[
        list[str] | None,
        typer.Option(
            metavar="MAP",
            rich_help_panel=INPUT,
            help="Name the columns yourself: target=hex,altitude_ft=alt,time_s=t.",
        ),
    ] = None
    altitude_unit: Annotated[
        AltitudeUnit | None,
        typer.Option(
            metavar="ft|m", rich_help_panel=INPUT, help="Unit of altitudes, if the column's name does not say it."
        ),
    ] = None
    time_unit: Annotated[
        TimeUnit | None,
        typer.Option(
            metavar="UNIT",
            rich_help_panel=INPUT,
            help="Unit of numeric times: s, ms, us or ns. Default: by the column's name or the numbers.",
        ),
    ] = None
    time_format: Annotated[
        str | None,
        typer.Option(
            metavar="FORMAT", rich_help_panel=INPUT, help="How times are written, as strftime: '%d/%m/%Y %H:%M'."
        ),
    ] = None
    time_zone: Annotated[
        str | None,
        typer.Option(
            metavar="ZONE",
            rich_help_panel=INPUT,
            help="Zone of times that name none, such as Europe/Berlin. Default: UTC.",
        ),
    ] = None
    day_first: Annotated[
        bool,
        typer.Option("--day-first", rich_help_panel=INPUT, help="Dates such as 03/04/2024 are in April.", **FLAG),
    ] = False
    month_first: Annotated[
        bool,
        typer.Option("--month-first", rich_help_panel=INPUT, help="Dates such as 03/04/2024 are in March.", **FLAG),
    ] = False
    axes: Annotated[
        Axes | None,
        typer.Option(
            metavar="enu|ned",
            rich_help_panel=INPUT,
            help="Where x, y and z point: east, north, up, or north, east, down. Default: enu.",
        ),
    ] = None
    azimuth_from: Annotated[
        AzimuthFrom | None,
        typer.Option(
            metavar="WHERE",
            rich_help_panel=INPUT,
            help="Azimuth counts clockwise from north, clockwise from grid north (UTM's, or that of --crs: grid), or "
            "counter-clockwise from east. Default: north.",
        ),
    ] = None
    crs: Annotated[
        str | None,
        typer.Option(
            metavar="CODE",
            rich_help_panel=INPUT,
            help="x and y are coordinates of this projection, such as EPSG:3857 (Web Mercator) or EPSG:32632.",
        ),
    ] = None
    site: Annotated[
        list[str] | None,
        typer.Option(
            metavar="LAT,LON",
            rich_help_panel=INPUT,
            help="Where the radar stands, also as LAT,LON,ALTITUDE. It puts x and y on the map. "
            "Of several radars one each: NAME=LAT,LON, where NAME is the source (a column, or the file).",
        ),
    ] = None
    anonymous: Annotated[
        bool,
        typer.Option(
            "--anonymous",
            rich_help_panel=PLOTS,
            help="Track plots that do not say whose they are, or ignore what they say. "
            "Default for a table without identity in which several rows share a time.",
            **FLAG,
        ),
    ] = False
    detection: Annotated[
        float | None,
        typer.Option(
            metavar="P",
            rich_help_panel=PLOTS,
            help="Probability that a scan sees a target. Default: estimated.",
        ),
    ] = None
    clutter: Annotated[
        float | None,
        typer.Option(metavar="N", rich_help_panel=PLOTS, help="False plots per scan. Default: learned from the plots."),
    ] = None
    association: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            rich_help_panel=PLOTS,
            help="How plots are given to tracks: {associations}. Default: marginal.",
            autocompletion=completed_from("associations"),
        ),
    ] = None
    new_per_hour: Annotated[
        float | None,
        typer.Option(metavar="N", rich_help_panel=PLOTS, help="Targets that come into view. Default: from the plots."),
    ] = None
    drop_after: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS",
            rich_help_panel=PLOTS,
            help="End a track after this time without a plot. Default: when it probably is gone.",
        ),
    ] = None
    period: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS",
            rich_help_panel=PLOTS,
            help="Time of one scan, where every plot has its own time. Default: rows of one time are a scan.",
        ),
    ] = None
    sectors: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            rich_help_panel=PLOTS,
            help="Take the plots of an antenna that turns in N sectors; 1: in whole turns. "
            "Default: 16, if --period is given and azimuths go with times.",
        ),
    ] = None
    gap: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS",
            rich_help_panel=CLEANING,
            help="Begin a new part after this time without a position; 0: never. Default: depends on the kind.",
        ),
    ] = None
    min_points: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            rich_help_panel=CLEANING,
            help="Reject parts with fewer positions than this; 1 keeps all. Default: 4.",
        ),
    ] = None
    no_sort: Annotated[
        bool,
        typer.Option(
            "--no-sort", rich_help_panel=CLEANING, help="Reject rows that are out of order; do not sort them.", **FLAG
        ),
    ] = False
    keep_duplicates: Annotated[
        bool,
        typer.Option("--keep-duplicates", rich_help_panel=CLEANING, help="Keep rows whose time occurs twice.", **FLAG),
    ] = False
    keep_stale: Annotated[
        bool,
        typer.Option(
            "--keep-stale",
            rich_help_panel=CLEANING,
            help="Believe a position that repeats although the target moves.",
            **FLAG,
        ),
    ] = False
    no_check: Annotated[
        bool,
        typer.Option("--no-check", rich_help_panel=CLEANING, help="Believe impossible coordinates and tracks.", **FLAG),
    ] = False


def run_track(request: TrackRequest) -> int:
    """Exit status: 0 done, 1 a failure that is not the input's fault, 2 unusable input or request."""
    # NumPy's products are small here, and its threads take as long to start as NumPy's import
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Where many calls are open, Python 3.11 takes and gives back memory of the system for each further one. The import
    # of NumPy makes thousands, so it comes first.
    import numpy  # noqa: F401

    archive = _is_archive(request.output)
    work = _run_live if "-" in request.inputs else _run_timed if request.timings else _run_files
    if archive:
        work = _run_archive
    return exit_status(
        lambda: work(request),
        mistakes=InputError,
        packages=(*PACKAGES, "pyarrow"),
        extra="archive" if archive else "track",
        memory="not enough memory; track fewer files at once",
        as_json=request.json,
    )


def settings_of(request: TrackRequest) -> tuple[Any, Any]:
    """What reading and tracking need to know."""
    from ..catalogue.choose import load_filter
    from ..io.loading import Reading
    from ..io.projections import with_grid
    from ..tracking.batch import Settings
    from ..tracking.lag import Lag
    from ..tracking.noise_level import parse_sensor_sd
    from ..tracking.prepare import sites_of
    from ..tracking.resampling import parse_every
    from ..tracking.unknown_height import TargetHeight

    check_kind(request.kind)
    site, sites = sites_of(parse_sites(request.site))
    settings = Settings(
        filter=load_filter(request.filter),
        kind=request.kind,
        smooth=request.smooth,
        lag=Lag.of(request.lag),
        sensor_sd=parse_sensor_sd(request.sensor_sd),
        site=site,
        sites=sites,
        gap=request.gap,
        min_points=Settings.min_points if request.min_points is None else request.min_points,
        sort=not request.no_sort,
        drop_duplicates=not request.keep_duplicates,
        drop_stale=not request.keep_stale,
        check=not request.no_check,
        threads=request.threads,
        velocity=not request.no_velocity,
        every=parse_every(request.every),
        manoeuvre_g=request.manoeuvre_g,
        target_height=TargetHeight.of(request.target_height),
    )
    columns = parse_columns(request.columns)
    checked, kept = not request.no_check, None if request.keep is None else tuple(words_of(request.keep))
    units = request.altitude_unit, request.time_unit
    conventions = with_grid(conventions_of(request), site, bool(sites))
    return Reading(columns, *units, checked, conventions, kept), settings


def conventions_of(request: TrackRequest) -> Any:
    """How dates and axes are to be read. Errors: InputError."""
    from ..io.conventions import Conventions

    if request.day_first and request.month_first:
        raise InputError("--day-first and --month-first exclude each other")
    order = True if request.day_first else False if request.month_first else None
    axes = request.axes.value if request.axes else None
    azimuth = request.azimuth_from.value if request.azimuth_from else None
    return Conventions(order, request.time_format, request.time_zone, axes, azimuth, request.crs)


def anonymous_of(request: TrackRequest) -> Any:
    """How plots without identity are to be tracked; None where nothing of it was asked for. Errors: InputError."""
    from ..tracking.anonymous_options import Anonymous

    names = ("detection", "clutter", "association", "new_per_hour", "drop_after", "period", "sectors")
    given = {name: getattr(request, name) for name in names if getattr(request, name) is not None}
    return Anonymous(**given) if request.anonymous or given else None


def _run_live(request: TrackRequest) -> int:
    """Standard input to standard output, line by line."""
    from ..tracking.live import LiveTracks
    from ..tracking.stream import answer

    _check_no_folder(request)
    if len(request.inputs) > 1:
        raise InputError("'-' stands alone: standard input cannot be tracked together with files")
    if anonymous_of(request) is not None:
        raise InputError("--anonymous needs whole scans: give a file, or use jink.Tracker.scan in Python")
    for given, option in (
        (request.smooth, "--smooth"),
        (request.report, "--report"),
        (request.tiles, "--tiles"),
        (request.output, "--output"),
        (request.json, "--json"),
        (request.keep, "--keep"),
        (request.every, "--every"),
        (request.safe_csv, "--safe-csv"),
        (request.timings, "--timings"),
        (request.min_points is not None, "--min-points"),
    ):
        if given:
            raise InputError(f"{option} needs the whole track; 'jink track -' writes JSON Lines to standard output")
    answer(sys.stdin.fileno(), LiveTracks(*settings_of(request)), quiet=request.quiet)
    return 0


def _is_archive(output: str | None) -> bool:
    """Whether an output is a folder of tracks: its name ends in /, it is a URL, or such a folder is there."""
    from ..archive.folder import is_archive

    return output is not None and (output.endswith(("/", os.sep)) or "://" in output or is_archive(output))


def _run_archive(request: TrackRequest) -> int:
    """Files to a folder, in processes or on a cluster."""
    from ..archive.run import How, track_archive
    from ..tracking.large_files import memory_of

    if "-" in request.inputs:
        raise InputError("'-' is a stream of lines; a folder takes files")
    reading, settings = settings_of(request)
    for given, option in (
        (request.report, "--report"),
        (request.tiles, "--tiles"),
        (request.timings, "--timings"),
        (request.every, "--every"),
        (anonymous_of(request), "--anonymous and its like"),
        (settings.sites, "--site of several radars"),
    ):
        if given:
            raise InputError(f"{option} cannot be used with a folder as output; write to a file such as tracks.parquet")
    memory = memory_of(request.memory)
    how = How(memory, request.threads, request.strict, request.append, request.cluster)
    with _events(request) as say:
        summary, written = track_archive(request.inputs, str(request.output), reading, settings, how, say)
    summary["written"] = written
    if request.json:
        sys.stdout.write(json_text(summary, default=str))
    elif not request.quiet:
        from ..report.summary_table import show

        show(summary)
    return 0


@contextmanager
def _events(request: TrackRequest) -> Iterator[Any]:
    """Lines of JSON on standard error with --json, one line that changes on a terminal, or nothing."""
    from .request import progress_line

    if request.json:
        yield lambda event: sys.stderr.write(json.dumps(event, ensure_ascii=False) + "\n")
        return
    with progress_line(not request.quiet) as line:

        def say(event: dict[str, Any]) -> None:
            if event["event"] == "file_skipped":
                sys.stderr.write(f"jink: left out: {event['why'].splitlines()[0]}\n")
            elif line is not None:
                line(_in_words(event))

        yield say


def _in_words(event: dict[str, Any]) -> str:
    if event["event"] == "settle":
        return "reading a sample"
    what = {"map": "dividing files", "reduce": "tracking buckets"}[event["event"]]
    left = "" if event["seconds_left"] is None else f", {event['seconds_left']:,.0f} s left"
    return f"{what}: {event['done']:,} of {event['of']:,}, {event['rows_per_second']:,} rows/s{left}"


def _run_timed(request: TrackRequest) -> int:
    """Files, and what each stage took."""
    from ..io.stages import recorded
    from ..report.timings_table import show_timings

    with recorded() as ledger:
        status = _run_files(request, ledger)
    if not request.json:
        show_timings(ledger.figures(), ledger.rows)
    return status


def _check_no_folder(request: TrackRequest) -> None:
    """Errors: InputError for options of archives, where none is written."""
    for given, option in ((request.append, "--append"), (request.strict, "--strict"), (request.cluster, "--cluster")):
        if given:
            raise InputError(f"{option} is for a folder of tracks: -o FOLDER/")


def _run_files(request: TrackRequest, ledger: Any = None) -> int:
    _check_no_folder(request)
    ahead.begin(request.inputs)
    from ..io.files import expand, name_of
    from ..io.spreadsheets import check_is_csv
    from ..io.writing import check_apart, check_writable, format_of
    from ..tracking.large import check_whole
    from ..tracking.large_files import memory_of

    began = clock.perf_counter()
    if request.quiet and not (request.output or request.report or request.json):
        raise InputError(
            "nothing to write: give -o tracks.parquet (or .csv, .jsonl, .geojson), --report page.html, "
            "or --json for the summary alone"
        )
    answered = request.output == "-"
    output = Path(request.output) if request.output and not answered else None
    report = Path(request.report) if request.report else None
    kind = format_of(output) if output else ""
    if request.safe_csv:
        check_is_csv(request.output, kind)
    check_tiles(request.tiles, report is not None)
    outputs = [path for path in (output, report) if path]
    for path in outputs:
        check_writable(path)
    check_apart([*outputs, *map(rejected_path, outputs[:1])], expand(request.inputs))
    reading, settings = settings_of(request)
    anonymous = anonymous_of(request)
    with _progress(request) as progress:
        done = _large(request, reading, settings, anonymous, output, kind, progress)
        if done is None:
            if request.memory is not None:
                check_whole(request.inputs, memory_of(request.memory))
            tracked, written = _in_memory(request, reading, settings, anonymous, output, kind, progress)
        else:
            tracked, written = done
    tracked.summary["written"] = [name_of(path) for path in written]
    tracked.summary["seconds"] = clock.perf_counter() - began
    if ledger is not None:
        ledger.rows = tracked.summary["rows"]
        tracked.summary["timings"] = ledger.figures()
    if request.json:
        sys.stdout.write(json_text(tracked.summary, allow_nan=True, default=str))
    elif answered:
        _answer(tracked, request.quiet)
    elif not request.quiet:
        from ..report.summary_table import show

        show(tracked.summary)
        if not written and tracked.tracks is not None:
            from ..report.first_tracks import show_first

            show_first(tracked.tracks)
    return 0


def _in_memory(
    request: TrackRequest, reading: Any, settings: Any, anonymous: Any, output: Path | None, kind: str, progress: Any
) -> tuple[Any, list[Path]]:
    """All files at once: the tracks, and what was written."""
    from .._engine import native
    from ..io.loading import load_files
    from ..io.writing import MAPS
    from ..tracking.batch import run

    # what fits in memory may keep it, so that no array costs new pages
    native.keep_freed_memory()
    loaded = load_files(request.inputs, reading, lambda done, total: progress("reading", done, total))
    if kind in MAPS and loaded.measurements.position != "geographic" and not (settings.site or settings.sites):
        raise InputError(
            f"{MAPS[kind]} needs places on the map: give --site LATITUDE,LONGITUDE for x, y or range, azimuth"
        )
    tracked = run(loaded, settings, progress, anonymous)
    return tracked, _write(tracked, output, kind, request, progress)


def _large(
    request: TrackRequest, reading: Any, settings: Any, anonymous: Any, output: Path | None, kind: str, progress: Any
) -> tuple[Any, list[Path]] | None:
    """The same share by share, without the tracks; None where memory suffices, or the table cannot be divided."""
    from ..tracking.batch import Tracked
    from ..tracking.large import fits
    from ..tracking.large_files import memory_of, track_large

    memory = memory_of(request.memory)
    if anonymous is not None or request.output == "-" or fits(request.inputs, memory):
        return None
    if settings.every is not None or settings.sites:
        return None
    report = Path(request.report) if request.report else None
    beside = output or report
    done = track_large(
        request.inputs,
        reading,
        settings,
        memory,
        (output, kind) if output else None,
        rejected_path(beside) if beside else None,
        progress,
        safe=request.safe_csv,
        page=(report, partial(_page_of, tiles=request.tiles)) if report else None,
    )
    return done and (Tracked(None, None, done[0]), done[1])


def _page_of(tracks: Any, path: Path, summary: dict[str, Any], tiles: str | None) -> None:
    from ..report import write_report

    write_report(tracks, path, summary=summary, tiles=tiles)


def _answer(tracked: Any, quiet: bool) -> None:
    """Tracks as JSON Lines on standard output, and on standard error what is in none."""
    from ..io.writing import write_tracks

    write_tracks(tracked.tracks, sys.stdout.buffer, "jsonl")
    if not quiet and tracked.rejected.height:
        why = ", ".join(f"{count:,} {reason}" for reason, count in tracked.summary["rejected"].items())
        sys.stderr.write(printable(f"jink: {tracked.rejected.height:,} rows are in no track: {why}\n"))


def _write(tracked: Any, output: Path | None, kind: str, request: TrackRequest, progress: Any) -> list[Path]:
    """All files or none: written under other names first, then renamed."""
    from ..io.spreadsheets import harmless
    from ..io.writing import atomically, write_packed, write_tracks

    report = Path(request.report) if request.report else None
    wanted = [path for path in (output, report) if path]
    if wanted:
        rejected = rejected_path(wanted[0])
        if tracked.rejected.height or rejected.exists():
            wanted.append(rejected)
    with atomically(*wanted) as temporary:
        for number, (path, name) in enumerate(zip(wanted, temporary, strict=True)):
            progress("writing", number, len(wanted))
            if path is output:
                tracks = harmless(tracked.tracks) if request.safe_csv else tracked.tracks
                if path.suffix == ".gz":
                    write_packed(tracks, name, kind)
                else:
                    write_tracks(tracks, name, kind)
            elif path is report:
                from ..report import write_report

                sky = getattr(tracked, "sky", None)
                write_report(tracked.tracks, name, summary=tracked.summary, sky=sky, tiles=request.tiles)
            else:
                with name.open("wb") as handle:
                    tracked.rejected.write_parquet(handle)
    return wanted


def rejected_path(beside: Path) -> Path:
    """`tracks.parquet` and `tracks.csv.gz` to `tracks.rejected.parquet`."""
    stem = Path(beside.name.removesuffix(".gz")).stem
    return beside.with_name(f"{stem}.rejected.parquet")


@contextmanager
def _progress(request: TrackRequest) -> Iterator[Any]:
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
