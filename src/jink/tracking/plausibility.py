"""What cannot be true of tracks: how it shows, the likely reason, and the option that mends it.

Every check looks at the finished table of tracks, so that files and the API are checked alike. The limits are wide: a
target of the right kind, in the right units, with one identity and honest time stamps passes all of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime, timedelta
from typing import Any

import numpy as np
import polars as pl

from ..catalogue.targets import KINDS, Kind
from ..io.stages import stage
from .cleaning import changes
from .correlated import correlated_errors
from .several import FACTOR, several_targets
from .slant import slant_height
from .stretches import CHUNK, pieces

FEWEST = 10  # measured rows of a target; of fewer nothing is said
TOO_FAST = 1.5  # times the kind's speed, by the median of a target
ABSURD = 10.0  # times the kind's speed: no setting of a filter mends that
TOO_SLOW = 0.02  # of the kind's speed, by the fastest of all targets
CRAWLS = 0.05  # m/s: nothing that is tracked goes on and on so slowly, in
STRAIGHT = 0.5  # of its path
TOO_HARD = 4.0  # times the kind's acceleration, by 90 % of the rows
REJECTED = 0.2  # share of a target's measured rows that were gated or began a track anew
JUMPS = 0.2  # share of steps that no target of the kind can make
REJECTED_ROWS = 5  # of them at least
HOPELESS = 0.4  # the same, above which the tracks are worth nothing
LEAST_SD, LARGEST_SD = 0.005, 20e3  # m, of a position's estimated noise
GIVEN = 5.0  # times the scatter of the data: a given noise is too large, if it is about their variance, or if
NIS_GIVEN = 0.15  # no mean NIS per dimension is above this, and
GIVEN_ANYHOW = 8.0  # it is so many times their scatter
NIS_MEAN = (0.05, 5.0)  # per dimension
NIS_ROWS = 100
CORRELATED = 0.5  # share of the targets whose errors are correlated
SHARED = 0.2  # of the rows, whose times are not their own
COARSE = 1800.0  # s: an even step of at least this is a clock of half hours or hours
OLDEST = datetime(1990, 1, 1, tzinfo=UTC)
NAMED = 5  # targets that a finding names


@dataclass(frozen=True)
class Finding:
    """One thing that cannot be true.

    code: its name in `--json`; what was found; targets it holds for, the first few by name; count of them and of rows;
    likely reason; mend: the option; fatal: nothing can be made of these targets.
    """

    code: str
    what: str
    targets: Sequence[str]
    count: int
    rows: int
    likely: str
    mend: str
    fatal: bool = False

    def sentence(self, of: int) -> str:
        """For people; `of` is the number of all targets."""
        if self.count == of:
            who = "all targets" if of > 1 else f"target {self.targets[0]}"
        else:
            who = ", ".join(self.targets) + (f" and {self.count - NAMED} more" if self.count > NAMED else "")
            who = f"target{'s' if self.count > 1 else ''} {who}"
        return f"{who}: {self.what}. Likely: {self.likely}. {self.mend}"


@dataclass(frozen=True)
class Seen:
    """What the checks look at, of whole targets: a row for each target, those under whose name there are several, rows
    of impossible dates, the number, least and largest of the steps of time, and how many rows were scored.
    """

    targets: pl.DataFrame
    shared: dict[str, int]
    dates: pl.DataFrame
    steps: tuple[int, float, float]
    scored: int

    @classmethod
    @stage("check")
    def of(cls, tracks: pl.DataFrame, kind: str, noise: Sequence[dict[str, Any]]) -> Seen:
        """Of a table of tracks; noise: the summary's lines, which say what is worth looking at."""
        targets = _by_target(tracks, KINDS[kind])
        targets = targets.join(_lasting(tracks, KINDS[kind], noise), on="target", how="left", maintain_order="left")
        names = targets.filter(_suspect())["target"]
        shared = {name: count for name in names if (count := several_targets(tracks, name, KINDS[kind])) > 1}
        # plots without identity have no NIS
        scored = int(((tracks["status"] == "updated") & tracks["nis"].is_not_null()).sum()) if "nis" in tracks else 0
        return cls(targets, shared, _wrong_dates(tracks), _steps(tracks), scored)

    @classmethod
    def together(cls, some: Sequence[Seen]) -> Seen:
        """Of tables that have no target in common."""
        count = sum(seen.steps[0] for seen in some)
        least, most = (pick(seen.steps[k] for seen in some) for pick, k in ((min, 1), (max, 2)))
        return cls(
            pl.concat([seen.targets for seen in some]),
            {name: count for seen in some for name, count in seen.shared.items()},
            pl.concat([seen.dates for seen in some]),
            (count, least, most),
            sum(seen.scored for seen in some),
        )


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
        *_noise(noise, targets),
        *_given(noise, targets, consistency),
        *_times(seen),
        *_shared_times(targets, shared),
        *_consistency(seen, noise, consistency),
        *_errors(targets, noise),
        *_slant(targets, noise),
    ]
    lost = {name for finding in found if finding.fatal for name in finding.targets}
    hopeless = bool(lost) and sum(f.count for f in found if f.fatal) >= targets.height
    return found, hopeless


def as_dicts(found: Sequence[Finding], targets: int) -> list[dict[str, Any]]:
    """What `--json` writes under `warnings`, with the sentence for people as `message`."""
    return [
        asdict(finding) | {"targets": list(finding.targets), "message": finding.sentence(targets)} for finding in found
    ]


def _by_target(tracks: pl.DataFrame, kind: Kind) -> pl.DataFrame:
    """One row per target: counts and quantiles of what the checks look at."""
    wanted = _looked_at(tracks, kind)
    tracks = tracks.select({"target", *(name for figure in wanted for name in figure.meta.root_names())})
    runs = tracks.select(pl.col("target").rle().alias("run")).unnest("run")
    if not 0 < runs["value"].n_unique() == runs.height:
        return tracks.group_by("target", maintain_order=True).agg(wanted)
    found = []
    for piece in pieces(np.r_[0, np.cumsum(runs["len"])]):
        if piece.part is None:
            # groups by rising numbers are told faster than by names
            number = pl.col("target").rle_id().set_sorted().alias("run")
            grouped = tracks[piece.rows].with_columns(number).group_by("run", maintain_order=True)
            found.append(grouped.agg(pl.col("target").first(), *wanted).drop("run"))
        elif piece.rows.start == piece.part.start:
            # a group is copied, for all figures at once: those of a long target are found one by one
            rows = tracks[piece.part]
            figures = [rows.select(figure) for figure in (pl.col("target").first(), *wanted)]
            found.append(pl.concat(figures, how="horizontal"))
    return pl.concat(found)


def _looked_at(tracks: pl.DataFrame, kind: Kind) -> list[pl.Expr]:
    """The figures of a target."""
    measured = pl.col("status") != "predicted"
    settled = pl.col("status") == "updated"
    acceleration = (
        (pl.col("acceleration_x") ** 2 + pl.col("acceleration_y") ** 2).sqrt()
        if "acceleration_x" in tracks.columns
        else pl.lit(None, pl.Float64)
    )
    time = pl.col("time").dt.epoch("us") / 1e6 if isinstance(tracks.schema["time"], pl.Datetime) else pl.col("time")
    leap = (pl.col("measured_x").diff() ** 2 + pl.col("measured_y").diff() ** 2).sqrt()

    def last(name: str) -> pl.Expr:
        known = pl.col(f"measured_{name}").drop_nulls()
        return known.last() - known.first()

    return [
        measured.sum().alias("measured"),
        pl.col("status").is_in(["gated", "restarted"]).sum().alias("rejected"),
        (pl.col("status") == "none").all().alias("without_estimate"),
        pl.col("speed").filter(settled).median().alias("speed"),
        pl.col("speed").filter(settled).quantile(0.95).alias("fast"),
        acceleration.filter(settled).quantile(0.1).alias("acceleration"),
        pl.col("speed").max().alias("fastest"),
        (leap > FACTOR * kind.speed * time.diff()).mean().alias("jumps"),
        leap.sum().alias("path"),
        (last("x") ** 2 + last("y") ** 2).sqrt().alias("away"),
        *((pl.col(f"measured_{c}").max() - pl.col(f"measured_{c}").min()).alias(f"spread_{c}") for c in "xy"),
    ]


def _named(some: pl.DataFrame) -> dict[str, Any]:
    return {"targets": some["target"].head(NAMED).to_list(), "count": some.height, "rows": int(some["measured"].sum())}


def _without_estimate(targets: pl.DataFrame) -> Iterator[Finding]:
    some = targets.filter("without_estimate")
    if some.height:
        yield Finding(
            "no_estimate",
            "no row has an estimate",
            **_named(some),
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
                f"half of the time faster than {_range(fast['speed'])} m/s; a target of kind {name} reaches about "
                f"{kind.speed:g} m/s",
                **_named(fast),
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
            f"nine tenths of the time beyond {_range(hard['acceleration'])} m/s²; a {name} pulls about "
            f"{kind.acceleration:g} m/s²",
            **_named(hard),
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
                **_named(known),
                likely=likely,
                mend=mend,
            )
    crawling = known.filter(
        (pl.col("fast") < CRAWLS) & (pl.col("away") > STRAIGHT * pl.col("path")) & (pl.col("measured") >= 2 * FEWEST)
    )
    if crawling.height and crawling.height == known.height:
        yield Finding(
            "too_slow",
            f"goes straight on at {_range(crawling['speed'])} m/s",
            **_named(crawling),
            likely="a wrong unit of position (kilometres?) or time (milliseconds?)",
            mend="--columns x_km=NAME,y_km=NAME or --time-unit ms names it",
        )


def _faster(speed: float) -> str:
    kinds = sorted((kind.speed, name) for name, kind in KINDS.items() if kind.speed >= speed)
    return f"--kind {kinds[0][1]} expects up to {kinds[0][0]:g} m/s; " if kinds else ""


def _often_rejected() -> pl.Expr:
    return (pl.col("rejected") >= REJECTED_ROWS) & (pl.col("rejected") > REJECTED * pl.col("measured"))


def _suspect() -> pl.Expr:
    """Targets whose name may be that of several."""
    return _often_rejected() | (pl.col("jumps") > JUMPS)


def _rejections(targets: pl.DataFrame, shared: dict[str, int], radars: int) -> Iterator[Finding]:
    """Targets whose positions the filter does not believe, told apart by whether several targets share a name; radars:
    how many sources of ranges are taken to stand at one place.
    """
    suspect = targets.filter(_suspect())
    bad = suspect.filter(_often_rejected() | pl.col("target").is_in(list(shared))).with_columns(
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
                **_named(some),
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
            **_named(still),
            likely="the wrong columns are taken for the position, its unit is wrong, or the source repeats one report",
            mend="--columns names them (longitude_deg=X,latitude_deg=Y)",
        )


def _noise(noise: Sequence[dict[str, Any]], targets: pl.DataFrame) -> Iterator[Finding]:
    """Estimated noise against what a sensor of positions can have."""
    for line in noise:
        sd = line.get("position_sd")
        if sd is None or line.get("position_sd_from") != "estimated" or LEAST_SD <= sd <= LARGEST_SD:
            continue
        small = sd < LEAST_SD
        yield Finding(
            "noise_tiny" if small else "noise_huge",
            f"the positions of {line['source']} scatter by {sd:.2g} m",
            **_named(targets),
            likely="positions that were smoothed or computed before, or a wrong unit"
            if small
            else "several targets under one name, or a wrong unit",
            mend="--sensor-sd sets the noise; --columns names units and identifiers",
            fatal=not small,
        )


def _given(noise: Sequence[dict[str, Any]], targets: pl.DataFrame, consistency: dict[str, float]) -> Iterator[Finding]:
    """Noise that was given against what the data show: a variance for an sd hides in no NIS, since targets turn.

    Errors that last scatter less than they are large, but not by their square.
    """
    small = consistency.get("mean_per_dimension", np.inf) < NIS_GIVEN and targets["error_sd"].null_count() > 0
    for line in noise:
        for name in ("position", "range", "altitude"):
            given, seen = line.get(f"{name}_sd"), line.get(f"{name}_sd_seen")
            if given is None or seen is None or given < GIVEN * seen:
                continue
            square = 0.5 < given / seen**2 < 2.0
            if not square and not (small and given > GIVEN_ANYHOW * seen):
                continue
            yield Finding(
                "noise_given",
                f"the given {name} noise is {_metres(given)} m, and {line['source']} scatters by {_metres(seen)} m",
                **_named(targets),
                likely="a variance, where a standard deviation is expected"
                if square
                else "noise that is set too large",
                mend=f"--sensor-sd {name}={_metres(seen)} is what the data show; without it, jink estimates the noise",
            )


def _metres(value: float) -> str:
    return f"{value:.2g}" if value < 100.0 else f"{value:.0f}"


def _wrong_dates(tracks: pl.DataFrame) -> pl.DataFrame:
    """Target and time of rows before satellites told the time, or after tomorrow."""
    if not isinstance(tracks.schema["time"], pl.Datetime):
        return tracks.select("target", "time").clear()
    late = pl.col("time") > datetime.now(UTC) + timedelta(days=1)
    return tracks.lazy().filter((pl.col("time") < OLDEST) | late).select("target", "time").collect()


def _steps(tracks: pl.DataFrame) -> tuple[int, float, float]:
    """The number, least and largest of the times between two rows of a target (s)."""
    count, least, most = 0, np.inf, -np.inf
    for first in range(0, tracks.height, CHUNK):
        time, target = (tracks[name][first : first + CHUNK + 1] for name in ("time", "target"))
        seconds = time.dt.epoch("ms").to_numpy() / 1e3 if isinstance(time.dtype, pl.Datetime) else time.to_numpy()
        step = np.diff(seconds)[~changes(target)[1:]]
        step = step[step > 0]
        count += step.size
        least, most = min(least, float(step.min(initial=np.inf))), max(most, float(step.max(initial=-np.inf)))
    return count, least, most


def _times(seen: Seen) -> Iterator[Finding]:
    """Dates that cannot be, and clocks that tick in minutes or hours."""
    wrong, targets = seen.dates, seen.targets
    if wrong.height:
        some = targets.filter(pl.col("target").is_in(wrong["target"].unique().to_list()))
        yield Finding(
            "dates",
            f"dates from {wrong['time'].min():%Y-%m-%d} to {wrong['time'].max():%Y-%m-%d}",  # type: ignore[str-format]
            **{**_named(some), "rows": wrong.height},
            likely="a wrong unit or form of time, or a receiver's clock that was not set",
            mend="--time-unit or --time-format says how time is written",
        )
    count, least, most = seen.steps
    if count >= FEWEST and least >= COARSE and most - least < 1e-6 * least:
        yield Finding(
            "coarse_step",
            f"every step is exactly {least:g} s",
            **_named(targets),
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
            **_named(targets),
            likely="time stamps that lost their seconds or fractions, or several targets under one name",
            mend="--columns time=NAME or target=NAME names the column that tells them apart",
        )


def _consistency(seen: Seen, noise: Sequence[dict[str, Any]], consistency: dict[str, float]) -> Iterator[Finding]:
    """The innovations of all rows against what the filter says of them; errors that last make them small."""
    mean = consistency.get("mean_per_dimension")
    if mean is None or NIS_MEAN[0] <= mean <= NIS_MEAN[1]:
        return
    if mean < NIS_MEAN[0] and any("lasting_sd" in line for line in noise):
        return
    if seen.scored < NIS_ROWS:
        return
    large = mean > NIS_MEAN[1]
    yield Finding(
        "inconsistent",
        f"innovations are {np.sqrt(mean):.2g} times what the filter expects (mean NIS {mean:.2g} per dimension)",
        **_named(seen.targets),
        likely="noise that is set too small, or another kind of target" if large else "noise that is set too large",
        mend="--sensor-sd sets the noise, --kind the motion",
    )


def _errors(targets: pl.DataFrame, noise: Sequence[dict[str, Any]]) -> Iterator[Finding]:
    """Errors that last: no filter takes them out, and where the noise does not count them, sds are too small."""
    some = targets.filter(pl.col("error_sd").is_not_null())
    counted = [line for line in noise if "lasting_sd" in line]
    if counted and some.height:
        sd, seconds = (float(np.median([line[name] for line in counted])) for name in ("lasting_sd", "lasting_seconds"))
        yield Finding(
            "correlated",
            f"errors of about {sd:.2g} m lasting about {seconds:.2g} s; they count as noise, and the sds of positions "
            "have them, but no filter takes them out",
            **_named(some),
            likely="a satellite receiver, or positions that were smoothed before",
            mend=f"--sensor-sd {sd:.2g} takes them for independent errors",
        )
        return
    if not (estimated := _for_independent(noise)):
        return
    assumed = max(estimated)
    some = targets.filter(pl.col("error_sd") > 2.0 * assumed)
    if not some.height or some.height < CORRELATED * targets.height:
        return
    sd, seconds = np.median(some["error_sd"].to_numpy()), np.median(some["error_seconds"].to_numpy())
    yield Finding(
        "correlated",
        f"errors of about {sd:.2g} m lasting about {seconds:.2g} s; the track takes {assumed:.2g} m of them for noise "
        "and the rest for motion, so its sds are too small",
        **_named(some),
        likely="a satellite receiver, or positions that were smoothed before",
        mend=f"--sensor-sd {sd:.2g} counts them as noise",
    )


def _for_independent(noise: Sequence[dict[str, Any]]) -> list[float]:
    """The sds (m) that were estimated as if errors were independent; where time stamps err, that lasts too."""
    if any(line.get("time_sd", 0.0) > 0 for line in noise):
        return []
    return [line["position_sd"] for line in noise if line.get("position_sd_from") == "estimated"]


def _lasting(tracks: pl.DataFrame, kind: Kind, noise: Sequence[dict[str, Any]]) -> pl.DataFrame:
    """Of each target: sd and seconds of errors that last, and the height above the radar that ranges without heights
    show; null where nothing shows, and where the noise leaves no check that asks."""
    ranges = any("range_sd" in line for line in noise)
    told = any("lasting_sd" in line or "given" in line.values() for line in noise)
    if not (ranges or told or _for_independent(noise)):
        nothing = {name: pl.lit(None, pl.Float64) for name in ("error_sd", "error_seconds", "slant")}
        return tracks.select(pl.col("target").unique()).with_columns(**nothing)
    rows = tracks.lazy().filter(pl.col("status").is_in(["updated", "initialised"]) & pl.col("measured_x").is_not_null())
    table = rows.select("target", "part", "time", "measured_x", "measured_y").collect()
    of = table.select(pl.struct("target", "part").rle_id().alias("part"))["part"].to_numpy().astype(np.int64)
    starts = np.flatnonzero(np.diff(of, prepend=-1))
    time = table["time"]
    seconds = time.dt.epoch("us").to_numpy() / 1e6 if isinstance(time.dtype, pl.Datetime) else time.to_numpy()
    plane = table.select("measured_x", "measured_y").to_numpy()
    names = table["target"].gather(starts)
    del table, time  # what follows takes several times as much
    told = correlated_errors(seconds, plane, of, starts.size)
    sd, lasting = told.sd, told.seconds
    slant = np.full(starts.size, np.nan)
    if ranges and "measured_z" not in tracks.columns and kind.extent[1] >= 1e3:
        ends = np.append(starts, len(seconds))[1:]
        slant = np.array(
            [slant_height(seconds[low:high], plane[low:high]) for low, high in zip(starts, ends, strict=True)]
        )
    found = {"error_sd": sd, "error_seconds": lasting, "slant": slant.astype(float)}
    parts = pl.DataFrame({"target": names, **found}).with_columns(pl.col(list(found)).fill_nan(None))
    return parts.group_by("target").agg(pl.col(list(found)).median())


def _slant(targets: pl.DataFrame, noise: Sequence[dict[str, Any]]) -> Iterator[Finding]:
    """Ranges without heights of targets that fly high above the radar."""
    high = targets.filter(pl.col("slant").is_not_null())
    if high.height and any("range_sd" in line for line in noise):
        yield Finding(
            "slant_range",
            f"paths bend as those of targets {high['slant'].min():.0f} to {high['slant'].max():.0f} m above the radar "
            "do",
            **_named(high),
            likely="slant ranges without heights, taken for ranges along the ground",
            mend="--columns elevation_deg=NAME or altitude=NAME gives the heights",
        )


def _range(values: pl.Series) -> str:
    low, high = float(values.to_numpy().min()), float(values.to_numpy().max())
    return f"{low:.3g}" if low == high else f"{low:.3g} to {high:.3g}"
