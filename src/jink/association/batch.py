"""A whole recording at once: scans in order, and the rows of every track that was ever confirmed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..checks import Array
from ..estimate import STATUS, Estimate
from ..times import seconds
from .picture import Picture
from .smoothing import Taken, smoothed


@dataclass(frozen=True)
class Scans:
    """Plots in scans: rows begin[k] to begin[k + 1] of z are scan k, at time[k], of sensor[k]; own: times of plots."""

    time: Array
    begin: NDArray[np.int64]
    z: Array
    covariance: Array | None = None
    sensor: Sequence[str | None] | None = None
    own: Array | None = None

    def __len__(self) -> int:
        return len(self.time)


@dataclass
class Tentative:
    """Rows of tracks that were never confirmed but probably existed, by track and time; position (n, axes)."""

    id: NDArray[np.int64]
    time: Array
    existence: Array
    position: Array


@dataclass
class Found:
    """Rows of tracks, by track and time; plot: row of z, −1 for none.

    lone: of each row of z, the probability that it is no track's. counts of the run: scans, plots, and how many scans
    were bounded ("crowded", "full", "inexact"). taken: the plots of each row with their weights, where they were kept.
    """

    id: NDArray[np.int64]
    time: Array
    scan: NDArray[np.int64]
    existence: Array
    confirmed: NDArray[np.bool_]
    age: NDArray[np.int64]
    plot: NDArray[np.int64]
    estimate: Estimate
    lone: Array
    tentative: Tentative
    counts: dict[str, int] = field(default_factory=dict)
    taken: Taken | None = None


def track_scans(
    tracker: Any, scans: Scans, progress: Callable[[int, int], None] | None = None, *, keep: bool = False
) -> Found:
    """Every scan through the tracker. keep: the weights of plots, for smoothing."""
    pictures: list[Picture] = []
    taken: list[dict[str, Any]] = []
    counts = {"scans": len(scans), "plots": 0, "unusable": 0, "crowded": 0, "full": 0, "inexact": 0, "living": 0}
    for k in range(len(scans)):
        rows = slice(int(scans.begin[k]), int(scans.begin[k + 1]))
        covariance = None if scans.covariance is None else scans.covariance[rows]
        sensor = None if scans.sensor is None else scans.sensor[k]
        own = None if scans.own is None else scans.own[rows]
        picture = tracker.scan(float(scans.time[k]), scans.z[rows], sensor, covariance=covariance, times=own)
        pictures.append(picture)
        if keep:
            taken.append(tracker.taken())
        for name in ("plots", "unusable", "crowded", "full", "inexact"):
            counts[name] += int(picture.report[name])
        counts["living"] = max(counts["living"], picture.report["living"])
        if progress and (k % 16 == 0 or k + 1 == len(scans)):
            progress(k + 1, len(scans))
    found, rows = _gathered(tracker, scans, pictures, counts)
    if keep:
        found.taken = Taken.joined(taken, scans.begin[:-1], tracker.filter.axes).some(rows)
    return found


def _gathered(
    tracker: Any, scans: Scans, pictures: list[Picture], counts: dict[str, int]
) -> tuple[Found, NDArray[np.int64]]:
    """What was found, and which rows of all pictures it has."""

    def joined(take: Callable[[Picture], Any]) -> Any:
        return np.concatenate([take(p) for p in pictures]) if pictures else np.zeros(0)

    ids = joined(lambda p: p.ids).astype(np.int64)
    confirmed = joined(lambda p: p.confirmed).astype(bool)
    scan = np.repeat(np.arange(len(pictures)), [len(p) for p in pictures])
    plot = joined(lambda p: p.plot).astype(np.int64)
    plot = np.where(plot >= 0, plot + scans.begin[:-1][scan], -1) if len(ids) else plot
    keep = np.isin(ids, np.unique(ids[confirmed]))
    order = np.lexsort((scan, ids))
    rows, others = order[keep[order]], order[~keep[order]]
    existence, time = joined(lambda p: p.existence), joined(lambda p: p.times)
    places = joined(lambda p: p.positions).reshape(len(ids), tracker.filter.axes)
    names = ("x", "P", "mode_probability", "status")
    results = {name: joined(lambda p, name=name: p.estimate.results[name])[rows] for name in names}
    f = tracker.filter
    found = Found(
        id=ids[rows],
        time=time[rows],
        scan=scan[rows],
        existence=existence[rows],
        confirmed=confirmed[rows],
        age=joined(lambda p: p.age).astype(np.int64)[rows],
        plot=plot[rows],
        estimate=Estimate(f.components, f.modes, results, f.non_manoeuvring),
        lone=joined(lambda p: p.lone),
        tentative=Tentative(ids[others], time[others], existence[others], places[others]),
        counts=counts,
    )
    return found, rows


def run_table(tracker: Any, data: Any, smooth: bool = False) -> Any:
    """A DataFrame with `time`, the sensor's components (x, y, …; SI), and `sensor` if there are several.

    Rows of one time (and sensor) are one scan. The same kind of DataFrame comes back: id, time, existence, confirmed,
    age, status, row (the plot's, null where there was none), the state's components and their sd. Errors: ValueError.
    """
    import polars as pl

    from ..io.frames import from_any, to_same

    table = from_any(data).with_row_index("__row")
    several = len(tracker.radars) > 1
    components = tracker.components_of(None if not several else next(iter(tracker.radars)))
    needed = ["time", *components, *(["sensor"] if several else [])]
    missing = [name for name in needed if name not in table.columns]
    if missing:
        raise ValueError(f"data: has no column {missing[0]!r}; expected {', '.join(needed)}")
    order = ["time", "sensor"] if several else ["time"]
    table = table.sort(*order, "__row")
    time = np.asarray(seconds(table["time"].to_numpy()), float)
    if not np.isfinite(time).all():
        raise ValueError(
            f"data: time is missing in row {int(table['__row'][int(np.flatnonzero(~np.isfinite(time))[0])])}"
        )
    new = np.r_[True, np.diff(time) > 0] if len(time) else np.zeros(0, bool)
    if several:
        new |= table["sensor"].ne_missing(table["sensor"].shift(1)).to_numpy()
    begin = np.flatnonzero(new)
    z = table.select(pl.col(components).cast(pl.Float64)).to_numpy()
    sensors = [str(table["sensor"][int(k)]) for k in begin] if several else None
    scans = Scans(time[begin], np.r_[begin, len(time)], z, None, sensors)
    found = track_scans(tracker, scans, keep=smooth)
    if smooth:
        found = smoothed(tracker, scans, found)
    rows = table["__row"].to_numpy()
    out: dict[str, Any] = {
        "id": found.id,
        "time": table["time"].gather(begin[found.scan]),
        "existence": found.existence,
        "confirmed": found.confirmed,
        "age": found.age,
        "status": [STATUS[k] for k in found.estimate.status],
        "row": pl.Series(np.where(found.plot >= 0, rows.astype(np.int64)[found.plot], -1)).replace(-1, None),
    }
    for name in found.estimate.components:
        out[name] = found.estimate[name]
    for name in found.estimate.components:
        out[f"{name}_sd"] = found.estimate.sd(name)
    return to_same(pl.DataFrame(out), data)
