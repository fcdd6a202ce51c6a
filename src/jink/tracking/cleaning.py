"""From measurements in any order to track parts; every step is counted and can be left out.

Impossible jumps are not cleaned here: what is impossible depends on the target, and the filter's gate knows
its state. At its first position a target has no state yet: there the next ones decide.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import polars as pl

from ..io.measurements import DIMENSIONS
from ..io.stages import stage
from ..io.values import codes_of, order_of, short
from .height_jumps import impossible_heights

STALE_SPEED = 0.5  # m/s: slower than this, a repeated position is a target at rest, not a position out of date
STALE_SPEED_AT_END = 5.0  # m/s: the same at the end of a track, where no next position tells
EARTH_RADIUS = 6_371_000.0


@dataclass(frozen=True)
class Cleaning:
    """Which steps are done: `gap` in seconds (0: never a new part), `min_points` positions per part, `fastest` (m/s)
    that a target of the kind goes (0: not known, first positions are believed).
    """

    gap: float = 300.0
    min_points: int = 4
    sort: bool = True
    drop_duplicates: bool = True
    drop_stale: bool = True
    fastest: float = 0.0


@dataclass
class Cleaned:
    """Rows by target, part and time with the columns `part` and `measured`, and what was done."""

    rows: pl.DataFrame
    rejected: list[pl.DataFrame] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=dict)

    def drop(self, bad: np.ndarray, reason: str) -> None:
        """Move the rows marked `bad` to the rejected ones."""
        if bad.any():
            mask = pl.Series(bad)
            self.rejected.append(
                self.rows.select("file", "row", "target").filter(mask).with_columns(reason=pl.lit(reason))
            )
            self.rows = self.rows.filter(~mask)


@stage("clean")
def clean(rows: pl.DataFrame, position: str, how: Cleaning) -> Cleaned:
    """Sort, drop duplicates, blank stale positions, split at gaps, drop first positions that the next contradict, blank
    heights that cannot be, drop what is too short, in this order.
    """
    state, gap = Cleaned(rows), how.gap if how.gap > 0 else np.inf
    _order(state, how.sort)
    state.rows = state.rows.with_columns(measured=measured_rows(state.rows, position))
    state.counts |= _duplicates(state, position) if how.drop_duplicates else {"duplicate_times": 0}
    state.counts["stale_positions"] = _stale(state, position, gap) if how.drop_stale else 0
    _parts(state, gap)
    if how.fastest > 0:
        state.counts["wrong_starts"] = _starts(state, position, how.fastest)
        _heights(state, position, how.fastest)
    _short(state, how.min_points)
    return state


def changes(*columns: pl.Series) -> np.ndarray:
    """Where any of the columns differs from the row before; the first row counts as different."""
    if not len(columns[0]):
        return np.zeros(0, bool)
    different = np.zeros(len(columns[0]), bool)
    for column in columns:
        different |= column.ne_missing(column.shift(1)).to_numpy()
    different[0] = True
    return different


def _order(state: Cleaned, sort: bool) -> None:
    """By target and time; rows earlier than one before them are counted, or rejected if not to be sorted."""
    codes, time = codes_of(state.rows["target"]), state.rows["time"].to_numpy()
    backwards = _backwards(codes, time)
    state.counts["unsorted"] = int(backwards.sum()) if sort else 0
    if not sort:
        state.counts["out_of_order"] = int(backwards.sum())
        state.drop(backwards, "time runs backwards")
        codes, time = codes[~backwards], time[~backwards]
    order = order_of(codes, time)
    if (np.diff(order) != 1).any():
        state.rows = state.rows[order]


def _backwards(codes: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Rows (N,) that are earlier than one of their target before them."""
    order = np.argsort(short(codes), kind="stable")
    new = np.diff(codes[order], prepend=-1) != 0
    inside = time[order]
    late = np.zeros(time.size, bool)
    if (~new & (np.diff(inside, prepend=-np.inf) < 0)).any():
        table = pl.DataFrame({"code": codes, "time": time})
        late = table.select((pl.col("time") < pl.col("time").cum_max().over("code")).alias("late"))["late"].to_numpy()
    return late


def measured_rows(rows: pl.DataFrame, position: str) -> pl.Series:
    """Rows that hold a position: both of latitude and longitude, any component of the others."""
    known = [rows[name].is_finite() for name in DIMENSIONS[position] if name in rows.columns]
    if position == "geographic":
        return (known[0] & known[1]).alias("measured")
    some = known[0]
    for component in known[1:]:
        some = some | component
    return some.alias("measured")


def _duplicates(state: Cleaned, position: str) -> dict[str, int]:
    """Second reports of one instant, unless of another sensor that measured something else; how many are of another
    place than all others of that instant.
    """
    rows = state.rows
    if not (~changes(rows["target"], rows["time"])).any():
        return {"duplicate_times": 0}
    names = [name for name in DIMENSIONS[position] if name in rows.columns]
    ranked = rows.with_row_index("place").sort("target", "time", pl.col("measured").not_(), "place")
    elsewhere = pl.col("measured") & pl.struct("target", "time", *names).is_first_distinct()
    first = pl.struct("target", "time").is_first_distinct()
    kept = first | (elsewhere & pl.struct("target", "time", "source").is_first_distinct())
    told = ranked.select("place", bad=~kept, elsewhere=elsewhere & ~kept)
    bad = np.zeros(rows.height, bool)
    bad[told["place"].to_numpy()] = told["bad"].to_numpy()
    state.drop(bad, "time occurs twice")
    return {"duplicate_times": int(bad.sum()), "shared_times": int(told["elsewhere"].sum())}


def _stale(state: Cleaned, position: str, gap: float) -> int:
    """Positions repeated while the target moves are old ones filled forward: they become misses.

    What tells rest from staleness is the distance to the next different position over the time between. At the end of
    a track, and before a gap, it is the speed before and the reported one, which elsewhere is often filled forward
    itself.
    """
    rows = state.rows
    several = not _in_order_of_sources(rows)
    order = (
        rows.with_row_index("place").sort("target", "source", "time")["place"].to_numpy()
        if several
        else np.arange(rows.height)
    )
    order = order[rows["measured"].to_numpy()[order]]
    names = [name for name in DIMENSIONS[position][:2] if name in rows.columns]
    held = rows.select("target", "source", "time", "speed", *names)
    held = held[order] if several or order.size < rows.height else held
    track = changes(held["target"], held["source"])
    start = track | changes(*[held[name] for name in names])
    starts = np.flatnonzero(start)
    if starts.size == held.height:
        return 0
    run = np.cumsum(start) - 1
    first, second = (held[name].to_numpy()[starts] for name in names)
    distance = distances(first, second, position)
    time = held["time"].to_numpy()
    elapsed = time[starts[1:]] - time[starts[:-1]]
    with np.errstate(divide="ignore", invalid="ignore"):
        pace = np.where(track[starts[1:]], np.nan, distance / elapsed)  # from run k to run k+1
    apart = time[starts[1:]] - time[starts[1:] - 1] > gap
    onward, inward = np.r_[np.where(apart, np.nan, pace), np.nan], np.r_[np.nan, pace]
    at_end = np.isnan(onward)
    moving = np.where(at_end, np.nan_to_num(inward) > STALE_SPEED_AT_END, onward > STALE_SPEED)
    resting = at_end[run] & (held["speed"].to_numpy() <= STALE_SPEED)
    stale = ~start & moving[run] & ~resting
    bad = np.zeros(rows.height, bool)
    bad[order[stale]] = True
    missing = pl.Series(bad)
    blanked = [name for name in DIMENSIONS[position] if name in rows.columns]
    state.rows = rows.with_columns(
        pl.col("measured") & ~missing,
        *[pl.when(missing).then(float("nan")).otherwise(pl.col(name)).alias(name) for name in blanked],
    )
    return int(bad.sum())


def _in_order_of_sources(rows: pl.DataFrame) -> bool:
    """Whether rows by target and time are those by target, source and time, as those of one file after the other."""
    source = rows["source"]
    later = np.flatnonzero(changes(source) & ~changes(rows["target"]))
    return bool((source.gather(later) > source.gather(later - 1)).fill_null(False).all())


def distances(first: np.ndarray, second: np.ndarray, position: str) -> np.ndarray:
    """Metres between consecutive positions, roughly: only to tell rest from motion. first, second: their components."""
    if position == "geographic":
        north = np.radians(np.diff(first)) * EARTH_RADIUS
        wrapped = (np.diff(second) + 180.0) % 360.0 - 180.0
        east = np.radians(wrapped) * EARTH_RADIUS * np.cos(np.radians(first[1:]))
        return np.hypot(north, east)
    if position == "polar":
        return np.abs(np.diff(first * np.exp(1j * second)))
    return np.hypot(np.diff(first), np.diff(second))


def _parts(state: Cleaned, gap: float) -> None:
    """A new part where no position came for longer than `gap`; rows far from any are dropped."""
    rows = state.rows
    time = rows["time"].to_numpy()
    measured = rows["measured"].to_numpy()
    new_target = changes(rows["target"])
    first = np.maximum.accumulate(np.where(new_target, np.arange(rows.height), 0))
    last = np.maximum.accumulate(np.where(measured, np.arange(rows.height), -1))
    unknown = last < first  # no position of this target yet
    state.counts["missing_positions"] = int((~measured).sum()) - state.counts.get("stale_positions", 0)
    far = ~unknown & (time - time[np.maximum(last, 0)] > gap)
    reason = np.where(unknown, 1, np.where(far, 2, 0))
    before, after = reason == 1, (reason == 2)[reason != 1]
    state.drop(before, "before the target's first position")
    state.drop(after, "no position for longer than the gap")
    state.counts["without_position"] = int((reason > 0).sum())
    rows = state.rows
    measured = rows["measured"].to_numpy()
    time = rows["time"].to_numpy()
    new_target = changes(rows["target"])
    latest = np.maximum.accumulate(np.where(measured, np.arange(rows.height), 0))
    before_this = np.r_[0, latest[:-1]] if rows.height else latest
    split = ~new_target & measured & (time - time[before_this] > gap)
    state.counts["gaps"] = int(split.sum())
    state.rows = rows.with_columns(part=pl.Series(_number_within(new_target, split)))


def _starts(state: Cleaned, position: str, fastest: float) -> int:
    """First positions of parts that the next three contradict: to come from there needs 1.3 times the kind's speed and
    three times theirs, while those follow each other steadily. (Whole-second stamps alone give twice the speed.)
    """
    rows = state.rows
    names = [name for name in DIMENSIONS[position][:2] if name in rows.columns]
    measured = np.flatnonzero(rows["measured"].to_numpy())
    held = rows.select("target", "part", "time", *names)[measured]
    new = changes(held["target"], held["part"])
    starts = np.flatnonzero(new)
    lengths = np.diff(np.r_[starts, held.height])
    starts = starts[lengths > 4]
    if not starts.size:
        return 0
    elapsed = np.diff(held["time"].to_numpy())
    with np.errstate(divide="ignore", invalid="ignore"):
        pace = distances(held[names[0]].to_numpy(), held[names[1]].to_numpy(), position) / elapsed
        first, after = pace[starts], np.array([pace[starts + k] for k in (1, 2, 3)])
        steady = np.ptp(after, axis=0) < 0.2 * first
        most = after.max(axis=0)
        wrong = (first > np.maximum(1.3 * fastest, 3.0 * most)) & (most <= fastest) & steady & np.isfinite(first)
    bad = np.zeros(rows.height, bool)
    bad[measured[starts[wrong]]] = True
    state.drop(bad, "the next positions contradict this first one")
    return int(bad.sum())


def _heights(state: Cleaned, position: str, fastest: float) -> None:
    """Heights that no target of the kind can climb to become misses, and their positions stay."""
    name = {"geographic": "altitude", "cartesian": "z"}.get(position, "")
    rows = state.rows
    if name not in rows.columns:
        return
    new = changes(rows["target"], rows["part"])
    bad, jumps = impossible_heights(rows["time"].to_numpy(), rows[name].to_numpy(), new, fastest)
    state.counts |= {"impossible_heights": int(bad.sum()), "height_jumps": jumps}
    if bad.any():
        missing = pl.when(pl.Series(bad)).then(float("nan")).otherwise(pl.col(name))
        state.rows = rows.with_columns(missing.alias(name))


def _short(state: Cleaned, min_points: int) -> None:
    """Parts with fewer than `min_points` positions are dropped whole; the rest is numbered again."""
    rows = state.rows
    new_part = changes(rows["target"], rows["part"])
    index = np.cumsum(new_part) - 1
    points = np.bincount(index, weights=rows["measured"].to_numpy(), minlength=int(new_part.sum()))
    short = points < min_points
    state.counts["short_parts"] = int(short.sum())
    if short.any():
        bad = short[index]
        state.counts["short_rows"] = int(bad.sum())
        state.drop(bad, f"fewer than {min_points} positions in this part of the track")
        rows = state.rows
        new_target = changes(rows["target"])
        state.rows = rows.with_columns(
            part=pl.Series(_number_within(new_target, changes(rows["target"], rows["part"]) & ~new_target))
        )


def _number_within(new_target: np.ndarray, split: np.ndarray) -> np.ndarray:
    """Number of splits since the target's first row."""
    total = np.cumsum(split)
    base = np.maximum.accumulate(np.where(new_target, np.arange(new_target.size), 0))
    return (total - total[base]).astype(np.int32) if new_target.size else np.zeros(0, np.int32)
