"""From measurements in any order to track parts; every step is counted and can be left out.

Impossible jumps are not cleaned here: what is impossible depends on the target, and the filter's gate knows
its state. At its first position a target has no state yet: there the next ones decide.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import polars as pl

from ..frozen import frozen
from ..io.evidence import between
from ..io.measurements import DIMENSIONS
from ..io.stages import stage
from ..io.values import codes_of, order_of, short, taken
from .height_jumps import impossible_heights

STALE_SPEED = 0.5  # m/s: slower than this, a repeated position is a target at rest, not a position out of date
STALE_SPEED_AT_END = 5.0  # m/s: the same at the end of a track, where no next position tells


@frozen
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
    """Rows by target, part and time with the columns `part` and `measured`, and what was done; codes (N,) number the
    targets of the rows.
    """

    rows: pl.DataFrame
    codes: np.ndarray
    rejected: list[pl.DataFrame] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=dict)

    def drop(self, bad: np.ndarray, *reasons: str) -> None:
        """Move the rows marked `bad` to the rejected ones; of several reasons, `bad` says which, from 1 on."""
        for number, reason in enumerate(reasons, 1):
            lost = np.flatnonzero(bad == number)
            if lost.size:
                named = self.rows.select("file", "row", "target")[lost]
                self.rejected.append(named.with_columns(reason=pl.lit(reason)))
        if bad.any():
            self.take(np.flatnonzero(bad == 0))

    def take(self, which: np.ndarray) -> None:
        """These rows in this order."""
        self.rows, self.codes = taken(self.rows, which), self.codes[which]


@stage("clean")
def clean(rows: pl.DataFrame, position: str, how: Cleaning) -> Cleaned:
    """Sort, drop duplicates, blank stale positions, split at gaps, drop first positions that the next contradict, blank
    heights that cannot be, drop what is too short, in this order. The rows are taken: their table is empty afterwards.
    """
    # whoever called still has the table: without its columns, it keeps none that was replaced
    own = pl.DataFrame([rows.drop_in_place(name) for name in rows.columns])
    state, gap = Cleaned(own, codes_of(own["target"])), how.gap if how.gap > 0 else np.inf
    del own
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


def changes(*columns: pl.Series | np.ndarray) -> np.ndarray:
    """Where any of the columns (numbers or texts) differs from the row before; the first row counts as different."""
    different = np.zeros(len(columns[0]), bool)
    different[:1] = True
    for column in columns:
        if isinstance(column, np.ndarray):
            here, before = column[1:], column[:-1]
            # NaN is equal to NaN
            different[1:] |= (here != before) & ((here == here) | (before == before))
        else:
            different |= column.ne_missing(column.shift(1)).to_numpy()
    return different


def _order(state: Cleaned, sort: bool) -> None:
    """By target and time; rows earlier than one before them are counted, or rejected if not to be sorted."""
    backwards = _backwards(state.codes, state.rows["time"].to_numpy())
    state.counts["unsorted"] = int(backwards.sum()) if sort else 0
    if not sort:
        state.counts["out_of_order"] = int(backwards.sum())
        state.drop(backwards, "time runs backwards")
    order = order_of(state.codes, state.rows["time"].to_numpy())
    if (np.diff(order) != 1).any():
        state.take(order)


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
    if changes(state.codes, rows["time"].to_numpy()).all():
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
    codes, sources, time = state.codes, codes_of(rows["source"]), rows["time"].to_numpy()
    order: slice | np.ndarray = slice(None)
    later = changes(sources) & ~changes(codes)
    if (sources[1:] < sources[:-1])[later[1:]].any():
        order = np.lexsort((time, sources, codes))
    measured = rows["measured"].to_numpy()[order]
    if not measured.all():
        order = np.arange(rows.height)[order][measured]
    names = [name for name in DIMENSIONS[position][:2] if name in rows.columns]
    time, place = time[order], [rows[name].to_numpy()[order] for name in names]
    track = changes(codes[order], sources[order])
    start = track | changes(*place)
    starts = np.flatnonzero(start)
    lengths = np.diff(starts, append=start.size)
    long = np.flatnonzero(lengths > 1)
    if not long.size:
        return 0

    def pace(run: np.ndarray) -> np.ndarray:
        """From some runs to the next ones; NaN where that is of another track."""
        inside = (run >= 0) & (run + 1 < starts.size)
        one, other = starts[run[inside]], starts[run[inside] + 1]
        found = np.full(run.size, np.nan)
        with np.errstate(divide="ignore", invalid="ignore"):
            speed = between([x[one] for x in place], [x[other] for x in place], position) / (time[other] - time[one])
        found[inside] = np.where(track[other], np.nan, speed)
        return found

    end = (starts + lengths)[long]
    silent = time[np.minimum(end, time.size - 1)] - time[end - 1] > gap
    onward = np.where(silent, np.nan, pace(long))
    at_end = np.isnan(onward)
    moving = np.where(at_end, np.nan_to_num(pace(long - 1)) > STALE_SPEED_AT_END, onward > STALE_SPEED)
    run = np.repeat(np.arange(long.size), lengths[long] - 1)
    resting = at_end[run] & (rows["speed"].to_numpy()[order][~start] <= STALE_SPEED)
    stale = ~start
    stale[stale] = moving[run] & ~resting
    bad = np.zeros(rows.height, bool)
    bad[order] = stale
    if bad.any():
        _blank(state, bad, [name for name in DIMENSIONS[position] if name in rows.columns])
        state.rows = state.rows.with_columns(pl.col("measured") & ~pl.Series(bad))
    return int(bad.sum())


def _blank(state: Cleaned, bad: np.ndarray, names: Sequence[str]) -> None:
    """Values of the rows marked `bad` become misses."""
    missing = pl.Series(bad)
    state.rows = state.rows.with_columns(
        pl.when(missing).then(float("nan")).otherwise(pl.col(name)).alias(name) for name in names
    )


def _parts(state: Cleaned, gap: float) -> None:
    """A new part where no position came for longer than `gap`; rows far from any are dropped."""
    time, measured = state.rows["time"].to_numpy(), state.rows["measured"].to_numpy()
    missing, known = np.flatnonzero(~measured), np.flatnonzero(measured)
    starts = np.flatnonzero(changes(state.codes))
    first = starts[np.searchsorted(starts, missing, side="right") - 1]
    last = np.r_[-1, known][np.searchsorted(known, missing)]
    unknown = last < first  # no position of this target yet
    state.counts["missing_positions"] = missing.size - state.counts.get("stale_positions", 0)
    far = ~unknown & (time[missing] - time[last] > gap)
    state.counts["without_position"] = int(np.count_nonzero(unknown | far))
    reason = np.zeros(time.size, np.uint8)
    reason[missing] = np.where(unknown, 1, 2 * far)
    state.drop(reason, "before the target's first position", "no position for longer than the gap")
    time, known = state.rows["time"].to_numpy(), np.flatnonzero(state.rows["measured"].to_numpy())
    new_target = changes(state.codes)
    split = np.zeros(time.size, bool)
    split[known[1:]] = np.diff(time[known]) > gap
    split &= ~new_target
    state.counts["gaps"] = int(split.sum())
    state.rows = state.rows.with_columns(part=pl.Series(_number_within(new_target, split)))


def _starts(state: Cleaned, position: str, fastest: float) -> int:
    """First positions of parts that the next three contradict: to come from there needs 1.3 times the kind's speed and
    three times theirs, while those follow each other steadily. (Whole-second stamps alone give twice the speed.)
    """
    rows = state.rows
    names = [name for name in DIMENSIONS[position][:2] if name in rows.columns]
    measured = np.flatnonzero(rows["measured"].to_numpy())
    starts = np.flatnonzero(changes(state.codes[measured], rows["part"].to_numpy()[measured]))
    lengths = np.diff(starts, append=measured.size)
    starts = starts[lengths > 4]
    if not starts.size:
        return 0
    five = measured[starts + np.arange(5)[:, None]]
    time, place = rows["time"].to_numpy()[five], [rows[name].to_numpy()[five] for name in names]
    with np.errstate(divide="ignore", invalid="ignore"):
        pace = between([x[:-1] for x in place], [x[1:] for x in place], position) / np.diff(time, axis=0)
        first, after = pace[0], pace[1:]
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
    new = changes(state.codes, rows["part"].to_numpy())
    bad, jumps = impossible_heights(rows["time"].to_numpy(), rows[name].to_numpy(), new, fastest)
    state.counts |= {"impossible_heights": int(bad.sum()), "height_jumps": jumps}
    if bad.any():
        _blank(state, bad, [name])


def _short(state: Cleaned, min_points: int) -> None:
    """Parts with fewer than `min_points` positions are dropped whole; the rest is numbered again."""
    starts = np.flatnonzero(changes(state.codes, state.rows["part"].to_numpy()))
    lengths = np.diff(starts, append=state.codes.size)
    short = np.add.reduceat(state.rows["measured"].to_numpy(), starts, dtype=int) < min_points
    state.counts["short_parts"] = int(short.sum())
    if short.any():
        bad = np.repeat(short, lengths)
        state.counts["short_rows"] = int(bad.sum())
        state.drop(bad, f"fewer than {min_points} positions in this part of the track")
        new_target = changes(state.codes)
        split = changes(state.codes, state.rows["part"].to_numpy()) & ~new_target
        state.rows = state.rows.with_columns(part=pl.Series(_number_within(new_target, split)))


def _number_within(new_target: np.ndarray, split: np.ndarray) -> np.ndarray:
    """Number of splits since the target's first row."""
    total, starts = np.cumsum(split, dtype=np.int32), np.flatnonzero(new_target)
    return total - np.repeat(total[starts], np.diff(starts, append=total.size))
