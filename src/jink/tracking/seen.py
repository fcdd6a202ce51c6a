"""What the checks of `plausibility` look at: figures of each target, and of the times of all."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime, timedelta
from typing import Any

import numpy as np
import polars as pl

from ..catalogue.targets import KINDS, Kind
from ..frozen import frozen
from ..io.stages import stage
from .cleaning import changes
from .correlated import correlated_errors
from .several import FACTOR, several_targets
from .slant import slant_height
from .stretches import CHUNK, pieces

REJECTED = 0.2  # share of a target's measured rows that were gated or began a track anew
REJECTED_ROWS = 5  # of them at least
JUMPS = 0.2  # share of steps that no target of the kind can make
OLDEST = datetime(1990, 1, 1, tzinfo=UTC)


@frozen
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
        names = targets.filter(suspicious())["target"]
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


def often_rejected() -> pl.Expr:
    return (pl.col("rejected") >= REJECTED_ROWS) & (pl.col("rejected") > REJECTED * pl.col("measured"))


def suspicious() -> pl.Expr:
    """Targets whose name may be that of several."""
    return often_rejected() | (pl.col("jumps") > JUMPS)


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


def sds_of_independent(noise: Sequence[dict[str, Any]]) -> list[float]:
    """The sds (m) that were estimated as if errors were independent; where time stamps err, that lasts too."""
    if any(line.get("time_sd", 0.0) > 0 for line in noise):
        return []
    return [line["position_sd"] for line in noise if line.get("position_sd_from") == "estimated"]


def _lasting(tracks: pl.DataFrame, kind: Kind, noise: Sequence[dict[str, Any]]) -> pl.DataFrame:
    """Of each target: sd and seconds of errors that last, and the height above the radar that ranges without heights
    show; null where nothing shows, and where the noise leaves no check that asks."""
    ranges = any("range_sd" in line for line in noise)
    told = any("lasting_sd" in line or "given" in line.values() for line in noise)
    if not (ranges or told or sds_of_independent(noise)):
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
