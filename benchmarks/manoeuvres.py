"""Is `manoeuvring` of real flights right? Against accelerations told by groundspeed and smoothed positions.

    python -m benchmarks.manoeuvres [FLIGHTS]     (without FLIGHTS the whole quickstart collection, fetched once)

Truth: along the track the slope of the reported groundspeed within 5 s, across it the curvature of a cubic through the
positions within 10 s; a manoeuvre lasts 5 s above .05 g. Neither knows of a filter. Every flight is tracked as
`jink track` does by default. Detection and false alarm: shares of rows with a probability above one half, among rows
that truly manoeuvre and among others. True of sure: the share of rows that truly manoeuvre, among rows with a
probability of at least .9. False segments: stretches of manoeuvre during which the flight never does.
Standard errors are over flights.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from benchmarks.commands import fetch_collection
from jink.io.loading import Reading, load_files
from jink.learn.recorded import local_cubic
from jink.tracking.batch import tables_of
from jink.tracking.lag import Lag
from jink.tracking.manoeuvring import ON
from jink.tracking.prepare import Group, Settings, prepare
from scripts.extract_flights import read

GRAVITY, THRESHOLD, LEAST, REACH = 9.80665, 0.05, 5.0, 5.0
SURE = 0.9  # probability from which on a row is sure to manoeuvre
LONGEST = 10.0  # s between two rows that count as time flown
WAYS = {
    "filtered": Settings(),
    "lag of 5 s": Settings(lag=Lag.of("5s")),
    "smoothed": Settings(smooth=True),
}
# detection at least, false alarms at most, false segments an hour at most
AIMS = {"filtered": (0.75, 0.08, None), "smoothed": (0.85, 0.06, 10.0)}


def slope(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Of the line through the values within REACH of each time; NaN where they are few or lie on one side."""
    known = np.flatnonzero(np.isfinite(values))
    out = np.full(time.size, np.nan)
    if known.size < 5:
        return out
    t, y = time[known] - time[0], values[known]
    sums = [np.r_[0.0, np.cumsum(each)] for each in (np.ones(t.size), t, y, t * t, t * y)]
    low = np.searchsorted(time[known], time - REACH)
    high = np.searchsorted(time[known], time + REACH, side="right")
    n, st, sy, stt, sty = (each[high] - each[low] for each in sums)
    with np.errstate(invalid="ignore", divide="ignore"):
        spread = stt - st * st / n
        good = (n >= 5) & (spread > n * (0.35 * REACH) ** 2)
        out[good] = ((sty - st * sy / n) / spread)[good]
    return out


def accelerations(group: Group) -> np.ndarray:
    """Horizontal acceleration (N,) of each row, m/s²; NaN where it is not known."""
    placed, out = group.placed, np.full(group.placed.time.size, np.nan)
    speed = placed.rows["speed"].to_numpy()
    for first, end in np.lib.stride_tricks.sliding_window_view(placed.offsets, 2).tolist():
        time, place = placed.time[first:end], placed.plane[first:end]
        _, _, curve = local_cubic(time, np.column_stack([place, placed.height[first:end]]))
        v = np.column_stack([slope(time, place[:, k]) for k in range(2)])
        with np.errstate(invalid="ignore", divide="ignore"):
            across = (v[:, 0] * curve[:, 1] - v[:, 1] * curve[:, 0]) / np.hypot(v[:, 0], v[:, 1])
        out[first:end] = np.hypot(across, slope(time, speed[first:end]))
    return out


def runs_of(flag: np.ndarray, new: np.ndarray) -> list[tuple[int, int]]:
    """First and last row of each stretch of True within a part."""
    begins = flag & np.r_[True, ~flag[:-1] | new[1:]]
    ends = flag & np.r_[~flag[1:] | new[1:], True]
    return list(zip(np.flatnonzero(begins).tolist(), np.flatnonzero(ends).tolist(), strict=True))


def sustained(flag: np.ndarray, time: np.ndarray, new: np.ndarray) -> np.ndarray:
    """True in stretches that last LEAST seconds."""
    out = np.zeros(flag.size, bool)
    for first, last in runs_of(flag, new):
        out[first : last + 1] = time[last] - time[first] >= LEAST
    return out


def ratio(part: np.ndarray, whole: np.ndarray) -> tuple[float, float]:
    """Ratio of sums and its standard error, from sums over flights."""
    value = part.sum() / whole.sum()
    return float(value), float(np.sqrt(((part - value * whole) ** 2).sum()) / whole.sum())


def scored(tracks: pl.DataFrame, group: Group, truth: np.ndarray, busy: np.ndarray) -> dict[str, tuple[float, float]]:
    """Detection, false alarm, true of sure and false segments an hour with their standard errors."""
    placed = group.placed
    probability = np.nan_to_num(tracks["manoeuvring"].fill_null(np.nan).to_numpy())
    known, says = np.isfinite(truth), probability > 0.5
    sure = (probability >= SURE) & known
    flight = pl.Series(placed.rows["target"]).rank("dense").to_numpy().astype(int) - 1
    count = int(flight.max()) + 1

    def over(values: np.ndarray) -> np.ndarray:
        return np.bincount(flight, values.astype(float), count)

    step = np.r_[np.diff(placed.time), 0.0]
    flown = over(np.where(known & (step > 0), np.minimum(step, LONGEST), 0.0)) / 3600.0
    false = np.zeros(count)
    segment = tracks["segment"].to_numpy()
    # a part's first stretch is a manoeuvre where its first row is told to be one; the others alternate
    begins = np.repeat(probability[placed.offsets[:-1]] > ON, np.diff(placed.offsets))
    for first, last in runs_of((segment % 2 == 1) ^ begins, placed.new):
        rows = slice(first, last + 1)
        false[flight[first]] += known[rows].all() and not busy[rows].any()
    return {
        "detection": ratio(over(says & busy & known), over(busy & known)),
        "false alarm": ratio(over(says & ~busy & known), over(~busy & known)),
        "true of sure": ratio(over(sure & busy), over(sure)),
        "false segments/h": ratio(false, flown),
    }


def measured(path: Path) -> dict[str, Any]:
    """What is found for each way to track the flights of a file that have heights; their number, hours and share."""
    measurements = load_files([str(path)], Reading()).measurements
    groups = prepare(measurements, Settings()).groups
    group = max(groups, key=lambda each: each.placed.time.size)
    placed, truth = group.placed, accelerations(group)
    with np.errstate(invalid="ignore"):
        busy = sustained(truth > THRESHOLD * GRAVITY, placed.time, placed.new)
    out: dict[str, Any] = {"flights": placed.rows["target"].n_unique(), "share": float(busy[np.isfinite(truth)].mean())}
    for name, settings in WAYS.items():
        tracks = pl.concat(list(tables_of(group, settings, measurements.absolute)))
        out[name] = scored(tracks, group, truth, busy)
    return out


def said(found: dict[str, Any]) -> str:
    """The table, with what was to be reached."""
    lines = [f"{found['flights']} flights, which manoeuvre in {found['share']:.0%} of the rows with known truth"]
    lines.append(f"{'':12}{'detection':>16}{'false alarm':>16}{'true of sure':>16}{'false segments/h':>18}")
    for name in WAYS:
        figures = [f"{value:.3f} ± {se:.3f}" for value, se in found[name].values()]
        columns = "".join(f"{figure:>{width}}" for figure, width in zip(figures, (16, 16, 16, 18), strict=True))
        lines.append(f"{name:12}{columns}  {_judged(name, found[name])}")
    return "\n".join(lines)


def _judged(name: str, figures: dict[str, tuple[float, float]]) -> str:
    if name not in AIMS:
        return ""
    least, most, often = AIMS[name]
    detection, alarm, segments = (figures[name][0] for name in ("detection", "false alarm", "false segments/h"))
    good = detection >= least and alarm <= most and (often is None or segments <= often)
    words = f"{least:g} at {most:g}" + ("" if often is None else f", {often:g}/h")
    return f"wanted {words}: {'reached' if good else 'MISSED'}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("flights", type=Path, nargs="?", help="a table of flights")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = given.flights
        if path is None:
            path = Path(folder) / "quickstart.parquet"
            read(fetch_collection()).sort("icao24", "time", maintain_order=True).write_parquet(path)
        print(said(measured(path)))


if __name__ == "__main__":
    main()
