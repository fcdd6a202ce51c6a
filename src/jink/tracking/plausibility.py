"""What cannot be true of tracks: how it shows, the likely reason, and the option that mends it.

Every check looks at the finished table of tracks, so that files and the API are checked alike. The limits are wide: a
target of the right kind, in the right units, with one identity and honest time stamps passes all of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import polars as pl

from ..catalogue.targets import KINDS
from ..io.stages import stage
from .finding import Finding, named, range_of
from .noise_findings import errors_that_last, estimated_noise, given_noise, inconsistent, slant_ranges
from .seen import Seen, often_rejected, suspicious

FEWEST = 10  # measured rows of a target; of fewer nothing is said
TOO_FAST = 1.5  # times the kind's speed, by the median of a target
ABSURD = 10.0  # times the kind's speed: no setting of a filter mends that
TOO_SLOW = 0.02  # of the kind's speed, by the fastest of all targets
CRAWLS = 0.05  # m/s: nothing that is tracked goes on and on so slowly, in
STRAIGHT = 0.5  # of its path
TOO_HARD = 4.0  # times the kind's acceleration, by 90 % of the rows
HOPELESS = 0.4  # the same, above which the tracks are worth nothing
SHARED = 0.2  # of the rows, whose times are not their own
COARSE = 1800.0  # s: an even step of at least this is a clock of half hours or hours


@stage("check")
def findings(
    seen: Seen, noise: Sequence[dict[str, Any]], kind: str, consistency: dict[str, float], shared: float = 0.0
) -> Any:
    """All findings of a run, and whether nothing plausible is left: every target is fatally wrong.

    shared: of the rows, the share that was dropped since its target was elsewhere at that time.
    """
    targets = seen.targets
    found = [
        *_without_estimate(targets),
        *_motion(targets, kind),
        *_rejections(targets, seen.shared, sum("range_sd" in line for line in noise)),
        *_stillness(targets),
        *estimated_noise(noise, targets),
        *given_noise(noise, targets, consistency),
        *_times(seen),
        *_shared_times(targets, shared),
        *inconsistent(seen, noise, consistency),
        *errors_that_last(targets, noise),
        *slant_ranges(targets, noise),
    ]
    lost = {name for finding in found if finding.fatal for name in finding.targets}
    hopeless = bool(lost) and sum(f.count for f in found if f.fatal) >= targets.height
    return found, hopeless


def _without_estimate(targets: pl.DataFrame) -> Iterator[Finding]:
    some = targets.filter("without_estimate")
    if some.height:
        yield Finding(
            "no_estimate",
            "no row has an estimate",
            **named(some),
            likely="no row holds a whole position: its components stand in separate rows, or a column is missing",
            mend="put what was measured together into one row; --columns names the columns",
            fatal=True,
        )


def _motion(targets: pl.DataFrame, name: str) -> Iterator[Finding]:
    """Speeds and accelerations against the kind's limits."""
    kind = KINDS[name]
    known = targets.filter(pl.col("measured") >= FEWEST)
    for low, high, fatal in ((TOO_FAST, ABSURD, False), (ABSURD, np.inf, True)):
        fast = known.filter((pl.col("speed") > low * kind.speed) & (pl.col("speed") <= high * kind.speed))
        if fast.height:
            yield Finding(
                "too_fast",
                f"half of the time faster than {range_of(fast['speed'])} m/s; a target of kind {name} reaches about "
                f"{kind.speed:g} m/s",
                **named(fast),
                likely="a wrong unit of position or time"
                if fatal
                else "another kind of target, or a wrong unit of position or time",
                mend=f"{_faster(fast['speed'].to_numpy().max())}--columns and --time-unit name units",
                fatal=fatal,
            )
    hard = known.filter(
        (pl.col("acceleration") > TOO_HARD * kind.acceleration) & (pl.col("speed") <= TOO_FAST * kind.speed)
    )
    if hard.height:
        yield Finding(
            "accelerates",
            f"nine tenths of the time beyond {range_of(hard['acceleration'])} m/s²; a {name} pulls about "
            f"{kind.acceleration:g} m/s²",
            **named(hard),
            likely="noise that is set too small, or several targets under one name",
            mend="--sensor-sd sets the noise",
        )
    if name in ("aircraft", "fighter") and known.height:
        top = float(np.nan_to_num(known["fast"].to_numpy()).max())
        slower = [other for other, that in KINDS.items() if that.speed < kind.speed / 3 and that.speed >= top]
        if 0 < top < TOO_SLOW * kind.speed and slower:
            fitting = min(slower, key=lambda other: KINDS[other].speed)
            likely, mend = "another kind of target", f"--kind {fitting} expects up to {KINDS[fitting].speed:g} m/s"
            if TOO_SLOW * kind.speed < 1000.0 * top <= TOO_FAST * kind.speed:
                likely = f"{likely}, or times in milliseconds, or x and y in kilometres"
                mend = f"{mend}; --time-unit ms or --columns x_km=NAME,y_km=NAME names the unit"
            yield Finding(
                "too_slow",
                f"none is faster than {top:.3g} m/s; a target of kind {name} reaches about {kind.speed:g} m/s",
                **named(known),
                likely=likely,
                mend=mend,
            )
    crawling = known.filter(
        (pl.col("fast") < CRAWLS) & (pl.col("away") > STRAIGHT * pl.col("path")) & (pl.col("measured") >= 2 * FEWEST)
    )
    if crawling.height and crawling.height == known.height:
        yield Finding(
            "too_slow",
            f"goes straight on at {range_of(crawling['speed'])} m/s",
            **named(crawling),
            likely="a wrong unit of position (kilometres?) or time (milliseconds?)",
            mend="--columns x_km=NAME,y_km=NAME or --time-unit ms names it",
        )


def _faster(speed: float) -> str:
    kinds = sorted((kind.speed, name) for name, kind in KINDS.items() if kind.speed >= speed)
    return f"--kind {kinds[0][1]} expects up to {kinds[0][0]:g} m/s; " if kinds else ""


def _rejections(targets: pl.DataFrame, shared: dict[str, int], radars: int) -> Iterator[Finding]:
    """Targets whose positions the filter does not believe, told apart by whether several targets share a name; radars:
    how many sources of ranges are taken to stand at one place.
    """
    suspect = targets.filter(suspicious())
    bad = suspect.filter(often_rejected() | pl.col("target").is_in(list(shared))).with_columns(
        (pl.col("rejected") > HOPELESS * pl.col("measured")).alias("hopeless")
    )
    for several in (True, False):
        for hopeless in (True, False):
            some = bad.filter((pl.col("target").is_in(list(shared)) == several) & (pl.col("hopeless") == hopeless))
            if not some.height:
                continue
            share = int(some["rejected"].sum()) / int(some["measured"].sum())
            if several:
                most = max(shared[name] for name in some["target"])
                what = (
                    f"is in {most} places in turn, each of them plausible alone ({100 * share:.0f} % of rows rejected)"
                )
                likely = f"{most} targets under one name"
                mend = "--columns target=NAME takes another identifier"
                if radars > 1:
                    likely = f"radars that stand at different places ({radars} sources), or {likely}"
                    mend = f"--site NAME=LAT,LON gives each radar its place; {mend}"
            else:
                what = f"{100 * share:.0f} % of the positions are not where the track can be"
                likely = (
                    "noise that is set too small, a wrong unit of time, another kind, or several targets under one name"
                )
                mend = "--sensor-sd, --time-unit, --kind or --columns target=NAME mends it"
            yield Finding(
                "several_targets" if several else "rejected",
                what,
                **named(some),
                likely=likely,
                mend=mend,
                fatal=hopeless,
            )


def _stillness(targets: pl.DataFrame) -> Iterator[Finding]:
    still = targets.filter(
        (pl.col("measured") >= FEWEST)
        & (((pl.col("spread_x") < 1e-3) & (pl.col("spread_y") < 1e-3)) | (pl.col("fastest") == 0.0))
    )
    if still.height:
        yield Finding(
            "never_moves",
            "never moves by a millimetre",
            **named(still),
            likely="the wrong columns are taken for the position, its unit is wrong, or the source repeats one report",
            mend="--columns names them (longitude_deg=X,latitude_deg=Y)",
        )


def _times(seen: Seen) -> Iterator[Finding]:
    """Dates that cannot be, and clocks that tick in minutes or hours."""
    wrong, targets = seen.dates, seen.targets
    if wrong.height:
        some = targets.filter(pl.col("target").is_in(wrong["target"].unique().to_list()))
        yield Finding(
            "dates",
            f"dates from {wrong['time'].min():%Y-%m-%d} to {wrong['time'].max():%Y-%m-%d}",  # type: ignore[str-format]
            **{**named(some), "rows": wrong.height},
            likely="a wrong unit or form of time, or a receiver's clock that was not set",
            mend="--time-unit or --time-format says how time is written",
        )
    count, least, most = seen.steps
    if count >= FEWEST and least >= COARSE and most - least < 1e-6 * least:
        yield Finding(
            "coarse_step",
            f"every step is exactly {least:g} s",
            **named(targets),
            likely="time stamps that lost their minutes or seconds, or positions that were sampled before",
            mend="--time-format or --columns time=NAME reads them; a track between such rows is a guess",
        )


def _shared_times(targets: pl.DataFrame, shared: float) -> Iterator[Finding]:
    """Time stamps that several positions of a target share: the first of each is kept."""
    if shared > SHARED:
        yield Finding(
            "shared_times",
            f"{100 * shared:.0f}% of the rows have the time of another row of their target, at another place; of each "
            "time the first is kept",
            **named(targets),
            likely="time stamps that lost their seconds or fractions, or several targets under one name",
            mend="--columns time=NAME or target=NAME names the column that tells them apart",
        )
