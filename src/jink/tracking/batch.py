"""The main job: positions in, tracks with velocity, acceleration, turn rate and manoeuvre probability out."""

from __future__ import annotations

import os
import time as clock
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, Literal, NamedTuple, TypedDict, TypeVar, Unpack, overload

import numpy as np
import polars as pl

from ..catalogue.choose import DEFAULTS
from ..catalogue.names import FilterName, KindName
from ..catalogue.targets import kind_of
from ..checks import items
from ..filters.axis_by_axis import AxisByAxis
from ..filters.bank import Bank
from ..io.conventions import Conventions
from ..io.errors import InputError
from ..io.loading import Loaded, Reading, load_files, load_frame
from ..io.projections import with_grid
from ..io.rejected import together
from .anonymous_options import Anonymous, is_anonymous
from .finding import Finding, as_dicts
from .foretold import foretells_badly, strays
from .lag import Lag
from .manoeuvring import Manoeuvres, told_of
from .noise_level import parse_sensor_sd
from .output import tracks_table
from .plausibility import findings
from .prepare import Group, Settings, prepare, sites_of
from .resampling import noise_of_steps, parse_every, resampled
from .seen import Seen
from .stretches import ManoeuvresGoOn, Run, Stretched, pieces
from .summary import reasons, summarise
from .unknown_height import TargetHeight
from .unseen_heights import with_doubt

if TYPE_CHECKING:
    from .sky_picture import SkyPicture

Progress = Callable[[str, int, int], None]
NOISE_OF_STEPS = (
    "the noise of this filter is that of a step from row to row, and --every makes steps shorter, so its estimates are "
    "others than those without it; that of imm, singer and csaf does not depend on rows"
)
F = TypeVar("F")  # a DataFrame of any library


class Tracked(NamedTuple, Generic[F]):
    """Tracks, the rows that are in none of them, and what was done and found."""

    tracks: F
    rejected: F
    summary: dict[str, Any]

    def report(self, path: str | os.PathLike[str]) -> None:
        """Write the page that ``jink track --report`` writes. Errors: OSError where it cannot be written."""
        # pages stand above this room: the public face finds them
        from jink import plot

        plot(self).save(path)


class TrackedSky(Tracked[F]):
    """The same of plots without identity. sky: what the page shows beside the tracks."""

    sky: SkyPicture

    @staticmethod
    def of(tracked: Tracked[Any], sky: SkyPicture) -> TrackedSky[Any]:
        """With what the page shows."""
        made = TrackedSky[Any](*tracked)
        made.sky = sky
        return made


class Options(TypedDict, total=False):
    """What :func:`track` can be told beside the data; see there."""

    filter: FilterName | Bank | AxisByAxis | None
    kind: KindName
    smooth: bool
    lag: int | str | None
    columns: Mapping[str, str] | None
    sensor_sd: float | str | Mapping[str, float] | None
    site: Sequence[float] | Mapping[str, Sequence[float]] | None
    gap: float | None
    min_points: int
    sort: bool
    drop_duplicates: bool
    drop_stale: bool
    check_coordinates: bool
    altitude_unit: Literal["ft", "m"] | None
    time_unit: Literal["s", "ms", "us", "ns"] | None
    day_first: bool | None
    time_format: str | None
    time_zone: str | None
    axes: Literal["enu", "ned"] | None
    azimuth_from: Literal["north", "east", "grid"] | None
    crs: str | None
    threads: int | None
    anonymous: bool | Mapping[str, object]
    velocity: bool
    keep: Sequence[str] | None
    every: float | str | None
    manoeuvre_g: float | None
    target_height: str | None


Files = str | Path | Sequence[str] | Sequence[Path]


@overload
def track(data: Files, *, details: Literal[False] = False, **options: Unpack[Options]) -> pl.DataFrame: ...
@overload
def track(data: Files, *, details: Literal[True], **options: Unpack[Options]) -> Tracked[pl.DataFrame]: ...
@overload
def track(data: F, *, details: Literal[False] = False, **options: Unpack[Options]) -> F: ...
@overload
def track(data: F, *, details: Literal[True], **options: Unpack[Options]) -> Tracked[F]: ...


def track(
    data: Any,
    *,
    filter: Any = None,
    kind: str = "aircraft",
    smooth: bool = False,
    lag: int | str | None = None,
    columns: Mapping[str, str] | None = None,
    sensor_sd: float | str | Mapping[str, float] | None = None,
    site: Sequence[float] | Mapping[str, Sequence[float]] | None = None,
    gap: float | None = None,
    min_points: int = 4,
    sort: bool = True,
    drop_duplicates: bool = True,
    drop_stale: bool = True,
    check_coordinates: bool = True,
    altitude_unit: str | None = None,
    time_unit: str | None = None,
    day_first: bool | None = None,
    time_format: str | None = None,
    time_zone: str | None = None,
    axes: str | None = None,
    azimuth_from: str | None = None,
    crs: str | None = None,
    threads: int | None = None,
    details: bool = False,
    anonymous: bool | Mapping[str, Any] = False,
    velocity: bool = True,
    keep: Sequence[str] | None = None,
    every: float | str | None = None,
    manoeuvre_g: float | None = None,
    target_height: str | None = None,
) -> Any:
    """Track every target in a DataFrame (the same kind comes back), a file, a pattern or several files.

    One row per accepted input row comes back (`row` is its place in the input): position, velocity,
    acceleration, speed, course, climb_rate, turn_rate in SI units and radians, each with its sd; a
    probability per mode, those of a manoeuvre (`manoeuvring`, horizontal, and `manoeuvring_vertical`), `segment`,
    `status`. Rows that are in no track are counted in a warning; with `details=True` the result is
    `Tracked(tracks, rejected, summary)` instead.

    Missing is null: speed, course and climb rate in a row that begins a track, the turn rate where speed is not two
    sds from zero. The course of a target at rest has an sd that says so.

    filter: a name of `jink.FILTERS` or a filter; None: imm-corrected for aircraft and fighters, imm for others and
    for all that is smoothed, lagged or without identity. smooth: every estimate uses its whole track; lag: only
    what was measured up to so many scans (2) or seconds ("8s") later. columns: role (with a unit if need be:
    `altitude_ft`) to column name. sensor_sd: metres, or per component (`{"range": 50, "azimuth_deg": 0.1}`); None:
    from columns of accuracy or estimated. site: latitude, longitude and altitude of a radar, or of several by the
    names of their sources.
    day_first, time_format (strftime), time_zone: how text dates are read. axes: "enu" or "ned";
    azimuth_from: "north" (clockwise), "east" (counter-clockwise), or "grid": clockwise from the north of a projection.
    crs: the projection of x and y, or of that north, as pyproj knows it ("EPSG:3857").
    gap: seconds without a position that begin a new part (0: never). anonymous: plots do not say whose they are; True,
    or any of detection, clutter, new_per_hour, drop_after, period, sectors and association by name
    (docs/plots-without-names.md). A table without identity, in which
    several rows share a time, is tracked so by itself. velocity: reported speeds, courses, vertical rates and range
    rates are used where they make held-out positions likelier; False leaves them out. keep: columns of the input that
    come back too (None: those that say who a target is). every: one row at each multiple of so many seconds ("1s"),
    predicted where nothing was measured, instead of one per input row. manoeuvre_g: the acceleration in g from which on
    `manoeuvring` and `manoeuvring_vertical` are probabilities of a manoeuvre (None: that of the kind). target_height:
    how high targets of a radar that measures no heights are above it, mean and sd in metres ("3000,2500"), or "ground".
    Raises InputError (a ValueError).
    """
    alone, sites = sites_of({} if site is None else site if isinstance(site, Mapping) else {"": site})
    settings = Settings(
        filter=filter,
        kind=kind,
        smooth=smooth,
        lag=Lag.of(lag),
        sensor_sd=parse_sensor_sd(sensor_sd),
        site=alone,
        sites=sites,
        gap=gap,
        min_points=min_points,
        sort=sort,
        drop_duplicates=drop_duplicates,
        drop_stale=drop_stale,
        check=check_coordinates,
        threads=threads,
        velocity=velocity,
        every=parse_every(every),
        manoeuvre_g=manoeuvre_g,
        target_height=TargetHeight.of(target_height),
    )
    conventions = Conventions(day_first, time_format, time_zone, axes, azimuth_from, crs)
    conventions = with_grid(conventions, alone, bool(sites))
    kept = None if keep is None else items("keep", keep, "names of columns")
    if kept and not all(isinstance(name, str) for name in kept):
        raise InputError(f"keep: expected names of columns, got {keep!r:.60}")
    reading = Reading(columns, altitude_unit, time_unit, check_coordinates, conventions, kept)
    tracked, back = _from_data(data, reading, settings, Anonymous.of(anonymous))
    if details:
        given_back = Tracked(back(tracked.tracks), back(tracked.rejected), tracked.summary)
        return TrackedSky.of(given_back, tracked.sky) if isinstance(tracked, TrackedSky) else given_back
    if tracked.rejected.height:
        why = ", ".join(f"{reason}: {n}" for reason, n in tracked.summary["rejected"].items())
        count = f"{tracked.rejected.height} of {tracked.summary['rows']} rows"
        warnings.warn(f"{count} are in no track ({why}); details=True returns them", stacklevel=2)
    return back(tracked.tracks)


def _from_data(
    data: Any, reading: Reading, settings: Settings, how: Anonymous | None
) -> tuple[Tracked, Callable[[pl.DataFrame], Any]]:
    """Tracks of files or of a DataFrame, and what turns them into the kind that was given."""
    if isinstance(data, str | Path):
        if not str(data) or "\0" in str(data):
            raise InputError(f"data: expected a file, a folder or a pattern, got {str(data)!r}")
        data = [data]
    if isinstance(data, Sequence) and data and all(isinstance(item, str | Path) for item in data):
        return run(load_files(data, reading), settings, anonymous=how), lambda frame: frame
    from ..io.frames import from_any, to_same

    tracked = run(load_frame(from_any(data), reading), settings, anonymous=how)
    bare = Tracked(tracked.tracks.drop("file"), tracked.rejected.drop("file"), tracked.summary)
    if isinstance(tracked, TrackedSky):
        bare = TrackedSky.of(bare, tracked.sky)
    return bare, lambda frame: to_same(frame, data)


def run(
    loaded: Loaded, settings: Settings, progress: Progress | None = None, anonymous: Anonymous | None = None
) -> Tracked:
    """Clean, place, filter; the summary says what was done. Plots without identity are given to targets first, where
    that is asked for, or where the table shows it. Raises InputError when no track is left, or none is plausible."""
    if anonymous is not None or is_anonymous(loaded.measurements):
        from .anonymous import run_anonymous  # all of association

        if settings.sites:
            raise InputError("site: plots without identity are tracked from one site; give one")
        if settings.every is not None:
            raise InputError("every: plots without identity are tracked scan by scan; leave it out")
        found = run_anonymous(loaded, settings, anonymous or Anonymous(), anonymous is not None, progress)
        tracked, apart = TrackedSky.of(Tracked(*found[:3]), found[3]), []
    else:
        tracked, apart = _run_named(loaded, settings, progress)
    measured = tracked.tracks if settings.every is None else tracked.tracks.filter(pl.col("row").is_not_null())
    noise = tracked.summary["noise"]
    seen = Seen.of(measured, settings.kind, noise)
    shared = tracked.summary["cleaning"].get("shared_times", 0) / tracked.summary["rows"]
    found, hopeless = findings(seen, noise, settings.kind, tracked.summary["consistency"], shared)
    found = [*apart, *found]
    if hopeless and settings.check:
        raise InputError(implausible(found, tracked.summary["targets"]))
    chosen = settings.filter is not None and not (isinstance(settings.filter, str) and settings.filter in DEFAULTS)
    if chosen and settings.smoothing is None:
        found += foretells_badly(measured)
        found += strays(measured, settings.filter, noise)
    tracked.summary["warnings"] = as_dicts(found, tracked.summary["targets"])
    return at_even_times(tracked, settings)


def at_even_times(tracked: Tracked, settings: Settings) -> Tracked:
    """The rows at even times alone, where those are asked for; what was found is of the measured rows."""
    if settings.every is None:
        return tracked
    tracks = tracked.tracks.filter("even").drop("even")
    count = int(tracks["row"].is_null().sum())
    tracked.summary["notes"].append(
        f"{tracks.height:,} rows, one every {settings.every:g} s; {count:,} of them lie between measurements"
    )
    return Tracked(tracks, tracked.rejected, tracked.summary | {"every_seconds": settings.every})


def _run_named(loaded: Loaded, settings: Settings, progress: Progress | None) -> tuple[Tracked, list[Finding]]:
    """Rows that say whose they are, and what is wrong with them before they are tracked."""
    began = clock.perf_counter()
    measurements = loaded.measurements
    prepared = prepare(measurements, settings)
    cleaned, groups = prepared.cleaned, prepared.groups
    rejected = together(measurements.rejected + cleaned.rejected)
    if not groups:
        raise InputError(nothing_left(loaded.count, reasons(rejected)))
    tables: list[pl.DataFrame] = []
    done = 0
    for group in groups:
        if settings.every is not None and getattr(group.filter, "counts_rows", False):
            raise InputError(f"every: {type(group.filter).__name__} counts rows, so rows between them would change it")
        for table in tables_of(group, settings, measurements.absolute):
            tables.append(table)
            done += table.height
            if progress:
                progress("filtering" if settings.smoothing is None else "smoothing", done, cleaned.rows.height)
    tracks = pl.concat(tables, how="diagonal")
    if len(groups) > 1:
        tracks = tracks.sort("target", "time", maintain_order=True)
    measured = tracks if settings.every is None else tracks.filter(pl.col("row").is_not_null())
    summary = summarise(loaded, cleaned, rejected, groups, measured, settings)
    summary |= {**settings.said(), "gap_seconds": prepared.pace.gap}
    if settings.every is not None and any(noise_of_steps(group.filter) for group in groups):
        summary["notes"].append(NOISE_OF_STEPS)
    return Tracked(tracks, rejected, summary | {"seconds": clock.perf_counter() - began}), prepared.apart


def nothing_left(count: int, why: Sequence[tuple[str, int]]) -> str:
    """What is said where all rows were rejected, for these reasons."""
    lines = "\n".join(f"  {count:>9,}  {reason}" for reason, count in why)
    short = any(reason.startswith("fewer than") for reason, _ in why)
    hint = "\n  --min-points 1 keeps single positions, such as those of one snapshot" if short else ""
    if any(reason.startswith("marked as not valid") for reason, _ in why):
        hint += "\n  --no-check believes rows that are marked as not valid"
    return f"no track is left: all {count:,} rows were rejected, because:\n{lines}{hint}"


def implausible(found: Sequence[Finding], targets: int) -> str:
    """What is said where no track can be true."""
    lines = "\n".join(f"  {finding.sentence(targets)}" for finding in found)
    return f"no track is plausible; --no-check writes them all the same\n{lines}"


def tables_of(group: Group, settings: Settings, absolute: bool) -> Iterator[pl.DataFrame]:
    """Tables of some ten thousand rows each, of whole parts or of a piece of a long one; one is made while the next is
    filtered. Errors: InputError for a filter that cannot be smoothed.
    """
    if settings.smoothing is not None and getattr(group.filter, "not_smoothed", ""):
        name, why = type(group.filter).__name__, group.filter.not_smoothed
        raise InputError(f"smooth: {name} cannot be smoothed: {why}")
    placed, covariance, even = group.placed, group.covariance, None
    if settings.every is not None:
        assert group.repeated is None
        grid = resampled(placed, covariance, settings.every)
        placed, covariance, even = grid.placed, grid.covariance, grid.even
    placed = with_doubt(placed, kind_of(settings.kind).climbs, settings.smooth, settings.lag)
    stretched = Stretched(group.filter, placed, group.repeated or covariance, settings.smoothing, settings.threads)
    what = Manoeuvres.of(group.filter, settings.kind, settings.manoeuvre_g, centred=settings.smooth)
    going_on = ManoeuvresGoOn(what)

    def table_of(run: Run, after: Run | None) -> pl.DataFrame:
        some = placed.some(run.piece.rows)
        if run.piece.part is None:
            manoeuvres = told_of(run.moving, some.new, what, any(run.estimate.non_manoeuvring))
        else:
            some = replace(some, new=np.arange(some.new.size) == 0)
            follows = after is not None and after.piece.part == run.piece.part
            manoeuvres = going_on.told(run.moving, after.moving if after and follows else None)
        table = tracks_table(some, run.estimate, absolute, manoeuvres, group.ground, run.state)
        return table if even is None else table.with_columns(even=pl.Series(even[run.piece.rows]))

    last: Run | None = None
    if settings.threads == 1:
        for piece in pieces(placed.offsets):
            run = Run.of(piece, stretched.run(piece), placed)
            if last:
                yield table_of(last, run)
            last = run
    else:
        waiting: Future[pl.DataFrame] | None = None
        with ThreadPoolExecutor(1) as worker:
            for piece in pieces(placed.offsets):
                run = Run.of(piece, stretched.run(piece), placed)
                if waiting:
                    yield waiting.result()
                waiting = worker.submit(table_of, last, run) if last else None
                last = run
            if waiting:
                yield waiting.result()
    if last:
        yield table_of(last, None)
