"""Plots without identity to tracks: scans are made of rows, targets of scans.

What is not given is estimated: a first pass assumes the kind's usual noise and a detection probability of 0.9. Its
tracks say what both are, and how many targets come into view, and further passes use that. The density of false plots
is learned on the way.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import polars as pl

from ..association.batch import Found, Scans, track_scans
from ..association.smoothing import smoothed
from ..association.tracker import Tracker
from ..association.turns import track_turns
from ..catalogue.targets import kind_of
from ..estimate import Status
from ..io.errors import InputError
from ..io.loading import Loaded
from ..io.rejected import together
from ..models.radar import Radar
from .anonymous_options import Anonymous
from .anonymous_rows import heights_above, placed_plots, placed_tracks, scans_of
from .beliefs import Beliefs, Given, assumed
from .manoeuvring import Manoeuvres, told
from .output import tracks_table
from .placing import Placed
from .prepare import Pace, Settings, choose
from .sky_picture import SkyPicture, sky_picture
from .summary import plain, reasons, words_for
from .unknown_height import height_of, on_the_ground

IN_THE_PLANE = "heights are not used: some plots without identity have none, or they are places on the map"
PASSES = 4  # at most, until what is believed changes by less than 5 %

Progress = Callable[[str, int, int], None]


def run_anonymous(
    loaded: Loaded, settings: Settings, how: Anonymous, asked: bool, progress: Progress | None = None
) -> tuple[pl.DataFrame, pl.DataFrame, dict[str, Any], SkyPicture]:
    """Tracks, plots in none of them, the summary, and what a page shows beside the tracks. Errors: InputError."""
    began = clock.perf_counter()
    measurements = loaded.measurements
    plots = placed_plots(measurements, settings.site)
    if not plots.rows.height:
        raise InputError("no plot is left: no row has a position")
    if plots.components == ("range", "azimuth"):
        name, above = measurements.named.get("range", ""), heights_above(plots)
        height, words = height_of(settings.target_height, settings.kind, name, above is not None)
        plots = plots if height.is_ground and above is None else on_the_ground(plots, height, above)
        measurements.notes += [words] if words else []
    elif plots.axes == 2 and any(plots.rows[n].is_finite().any() for n in ("altitude", "z") if n in plots.rows.columns):
        measurements.notes.append(IN_THE_PLANE)
    scans = scans_of(plots, how.period, how.sectors)
    believed, _ = beliefs_of(plots, scans, settings, how)
    found, filter, tracker = _pass(plots, scans, believed, settings, how, progress, True)
    if not len(found.id):
        raise InputError(
            f"no track was confirmed in {len(scans):,} scans of {plots.rows.height:,} plots; "
            "check --sensor-sd, --detection, --kind and the unit of the columns"
        )
    rows = placed_tracks(plots, found)
    picture = sky_picture(plots, found)
    if settings.smoothing is not None:
        found = _smoothed(tracker, scans, found, settings.smoothing)
    busy = Manoeuvres.of(filter, settings.kind, settings.manoeuvre_g, centred=settings.smooth)
    table = sky_table(rows, found, measurements.absolute, busy)
    used = picture.plots["used"].to_numpy()
    unused = plots.rows.filter(~used).select("file", "row").with_columns(reason=pl.lit("in no track: a false plot"))
    rejected = together([*measurements.rejected, unused])
    summary = _summary(loaded, settings, table, rejected, found, filter, believed.sd, int(used.sum()))
    clutter = ", ".join(f"{count:.3g}" for count in tracker.clutter_per_scan.values())
    how_said = "as asked" if asked else "the table has no identity column and several rows of one time"
    summary["notes"] += [
        f"plots have no identity ({how_said}): {len(scans):,} scans of {interval_of(scans):.5g} s, "
        f"association {how.association}",
        *_turning_said(scans, how),
        f"detection probability {believed.detection:.2f} ({'estimated' if how.detection is None else 'given'})",
        f"about {believed.new_per_hour or 0:.3g} new targets an hour "
        f"({'estimated' if how.new_per_hour is None else 'given'})",
        f"about {clutter} false plots per scan (learned)",
    ]
    for name, what in (("crowded", "more plots in a gate than are looked at"), ("full", "no room for more tracks")):
        if found.counts[name]:
            summary["notes"].append(f"{found.counts[name]:,} scans had {what}")
    summary["association"] = {"detection": believed.detection, "association": how.association, **found.counts}
    if scans.turning is not None:
        summary["association"] |= {"period": scans.turning.period, "sectors": scans.turning.sectors}
    return table, rejected, summary | {"seconds": clock.perf_counter() - began}, picture


def beliefs_of(plots: Placed, scans: Scans, settings: Settings, how: Anonymous) -> tuple[Beliefs, float]:
    """What the tracks of some passes say, and the false plots per scan that the last of them learned."""
    believed = assumed(plots, settings, how.detection, how.new_per_hour)
    given = Given(settings, how.detection is not None, how.new_per_hour is not None)
    clutter = 0.0
    for _ in range(PASSES):
        found, _, tracker = _pass(plots, scans, believed, settings, how, None)
        clutter = sum(tracker.clutter_per_scan.values())
        if not len(found.id):
            break
        before = believed
        believed = believed.corrected(found, placed_tracks(plots, found), scans.time, given)
        if believed.like(before):
            break
    return believed, clutter


def interval_of(scans: Scans) -> float:
    """Seconds from scan to scan."""
    return float(np.median(np.diff(scans.time))) if len(scans) > 1 else 1.0


def _turning_said(scans: Scans, how: Anonymous) -> list[str]:
    """What was found of an antenna that turns."""
    turning = scans.turning
    if turning is None:
        return []
    sense = "clockwise" if turning.clockwise else "counter-clockwise"
    whole = "" if how.sectors else "; --sectors 1 takes turns whole"
    found = "" if how.period else " (found)"
    return [f"the antenna turns {sense} in {turning.period:.5g} s{found}: {turning.sectors} sectors a turn{whole}"]


def _pass(
    plots: Placed,
    scans: Scans,
    believed: Beliefs,
    settings: Settings,
    how: Anonymous,
    progress: Progress | None,
    last: bool = False,
) -> tuple[Found, Any, Tracker]:
    _, filter = choose(plots.components, believed.sd, Pace.of(interval_of(scans), settings), settings, corrected=False)
    radar = Radar(detection=believed.detection, clutter_per_scan=how.clutter)
    try:
        tracker = Tracker(
            filter,
            radar,
            new_per_hour=believed.new_per_hour,
            targets=believed.targets,
            drop_after=how.drop_after,
            speed_sd=kind_of(settings.kind).speed / 2,
            association=how.association,
            threads=settings.threads,
        )
    except (ValueError, TypeError) as error:
        raise InputError(str(error)) from None
    run = track_scans if scans.turning is None else track_turns
    step = (lambda done, total: progress("tracking", done, total)) if progress else None
    keep = last and settings.smoothing is not None
    return run(tracker, scans, step, keep=keep), filter, tracker


def _smoothed(tracker: Tracker, scans: Scans, found: Found, lag: dict[str, Any]) -> Found:
    try:
        return smoothed(tracker, scans, found, **lag)
    except ValueError as error:
        raise InputError(str(error)) from None


def sky_table(rows: Placed, found: Found, absolute: bool, what: Manoeuvres) -> pl.DataFrame:
    """The table of tracks, with existence, whether confirmed, and age."""
    results = found.estimate.results | {"nis": np.full(len(found.id), np.nan), "nis_dof": np.zeros(len(found.id))}
    estimate = replace(found.estimate, results=results)
    table = tracks_table(rows, estimate, absolute, told(estimate, rows.time, rows.new, what))
    table = table.with_columns(
        existence=found.existence, confirmed=found.confirmed, age=pl.Series(found.age, dtype=pl.Int32)
    )
    return table.drop("nis", "nis_dof")


def _summary(
    loaded: Loaded,
    settings: Settings,
    table: pl.DataFrame,
    rejected: pl.DataFrame,
    found: Found,
    filter: Any,
    sd: dict[str, float],
    used: int,
) -> dict[str, Any]:
    times = table["time"]
    origin = {name: "given" if name in settings.sensor_sd else "estimated" for name in sd}
    line: dict[str, Any] = {"source": "plots", "rows": used, "groups": 1, "axes": filter.axes}
    for name, value in sd.items():
        line |= {f"{name}_sd": value, f"{name}_sd_from": origin[name]}
    measurements = loaded.measurements
    notes = [note for note in measurements.notes if not note.startswith("no identifier column")]
    statuses = table["status"].value_counts(sort=True).iter_rows()
    return {
        "files": loaded.files,
        "rows": loaded.count,
        "accepted": used,
        "rejected": dict(reasons(rejected)),
        "targets": table["target"].n_unique(),
        "parts": table["target"].n_unique(),
        "start": plain(times.min()),
        "end": plain(times.max()),
        "columns": {role: name for role, name in measurements.named.items() if role != "target"},
        "notes": notes,
        "cleaning": {},
        "noise": [line],
        "filter": {f"{filter.axes} axes": words_for(filter)},
        "status": {str(status): count for status, count in statuses},
        "consistency": {},
        **settings.said(),
        "gap_seconds": 0.0,
        "predicted": int((found.estimate.status == Status.predicted).sum()),
    }
