"""A whole recording at once: scans in order, and the rows of every track that was ever confirmed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..checks import Array
from ..estimate import STATUS, Estimate
from ..frozen import frozen
from ..times import seconds
from .picture import Picture
from .smoothing import Taken, smoothed


@frozen
class Turning:
    """An antenna that turns once in period (s); its turns are taken in so many sectors."""

    period: float
    sectors: int
    clockwise: bool = True


@frozen
class Scans:
    """Plots in scans: rows begin[k] to begin[k + 1] of z are scan k, at time[k], of sensor[k]; own: times of plots.

    turning: rows are taken sector by sector, by their own times; a scan is then a turn.
    """

    time: Array
    begin: NDArray[np.int64]
    z: Array
    covariance: Array | None = None
    sensor: Sequence[str | None] | None = None
    own: Array | None = None
    turning: Turning | None = None

    def __len__(self) -> int:
        return len(self.time)

    def turn_of(self, times: Array) -> NDArray[np.int64]:
        """In which scan times lie, where an antenna turns."""
        assert self.turning is not None
        after = np.searchsorted(self.time, times - self.turning.period / 2)
        return np.minimum(after, len(self) - 1).astype(np.int64)


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
    new: rows that do not follow from the one before: a track's first, and where it goes on elsewhere under its name.
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
    new: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))


@frozen
class _Seen:
    """The rows of one picture that count: all, or with sectors those that were due or had a plot.

    scan: of each row; offered: the row of z of each plot of the scan, to which ``lone`` belongs; part: how often the
    row's id has been handed on until then.
    """

    scan: NDArray[np.int64]
    picture: Picture
    rows: NDArray[np.int64]
    offered: NDArray[np.int64]
    taken: Taken | None
    part: NDArray[np.int64]


Pictures = Iterator[tuple[int, Picture, NDArray[np.int64]]]


def track_scans(
    tracker: Any,
    scans: Scans,
    progress: Callable[[int, int], None] | None = None,
    *,
    keep: bool = False,
    pictures: Pictures | None = None,
) -> Found:
    """Every scan through the tracker. keep: the weights of plots, for smoothing.

    pictures: of each the number of its scan, itself with plots as rows of z, and the rows that it was offered; None:
    one of each scan.
    """
    seen: list[_Seen] = []
    handed: Counter[int] = Counter()
    counts = {"scans": len(scans), "plots": 0, "unusable": 0, "crowded": 0, "full": 0, "inexact": 0, "living": 0}
    for k, picture, offered in _by_scans(tracker, scans) if pictures is None else pictures:
        rows, scan = np.arange(len(picture)), np.full(len(picture), k)
        if scans.turning:
            rows = np.flatnonzero(picture.due | (picture.plot >= 0))
            scan = scans.turn_of(picture.times[rows])
        taken = Taken.of(tracker.taken(), offered).some(rows) if keep else None
        handed.update(now for now, _ in picture.report["handed"])
        part = np.array([handed[each] for each in picture.ids[rows].tolist()], np.int64)
        seen.append(_Seen(scan, picture, rows, offered, taken, part))
        for name in ("plots", "unusable", "crowded", "full", "inexact"):
            counts[name] += int(picture.report[name])
        counts["living"] = max(counts["living"], picture.report["living"])
        if progress and (k % 16 == 0 or k + 1 == len(scans)):
            progress(k + 1, len(scans))
    if scans.turning:
        counts["plots"] = len(scans.z) - counts["unusable"]
    return _gathered(tracker, scans, seen, counts)


def _by_scans(tracker: Any, scans: Scans) -> Pictures:
    """One of each scan, whole."""
    for k in range(len(scans)):
        begin, end = int(scans.begin[k]), int(scans.begin[k + 1])
        rows = slice(begin, end)
        covariance = None if scans.covariance is None else scans.covariance[rows]
        sensor = None if scans.sensor is None else scans.sensor[k]
        own = None if scans.own is None else scans.own[rows]
        picture = tracker.scan(float(scans.time[k]), scans.z[rows], sensor, covariance=covariance, times=own)
        plot = np.where(picture.plot >= 0, picture.plot + begin, -1)
        yield k, replace(picture, plot=plot), np.arange(begin, end)


def _gathered(tracker: Any, scans: Scans, seen: list[_Seen], counts: dict[str, int]) -> Found:
    """What was found in all pictures."""

    def joined(take: Callable[[Picture], Any]) -> Any:
        return np.concatenate([take(one.picture)[one.rows] for one in seen]) if seen else np.zeros(0)

    ids = joined(lambda p: p.ids).astype(np.int64)
    confirmed = joined(lambda p: p.confirmed).astype(bool)
    part = np.concatenate([one.part for one in seen]) if seen else np.zeros(0, np.int64)
    scan = np.concatenate([one.scan for one in seen]) if seen else np.zeros(0, np.int64)
    plot = joined(lambda p: p.plot).astype(np.int64)
    keep = np.isin(ids, np.unique(ids[confirmed]))
    order = np.lexsort((np.arange(len(ids)), ids))
    rows, others = order[keep[order]], order[~keep[order]]
    existence, time = joined(lambda p: p.existence), joined(lambda p: p.times)
    places = joined(lambda p: p.positions).reshape(len(ids), tracker.filter.axes)
    names = ("x", "P", "mode_probability", "status")
    results = {name: joined(lambda p, name=name: p.estimate.results[name])[rows] for name in names}
    # of a plot that was offered twice, what was said last
    lone = np.full(len(scans.z), np.nan)
    for one in seen:
        lone[one.offered] = one.picture.lone
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
        lone=lone,
        tentative=Tentative(ids[others], time[others], existence[others], places[others]),
        counts=counts,
        new=(np.diff(ids[rows], prepend=-1) != 0) | (np.diff(part[rows], prepend=0) != 0),
    )
    if seen and seen[0].taken is not None:
        found.taken = Taken.joined([one.taken for one in seen if one.taken is not None]).some(rows)
    return found


def run_table(tracker: Any, data: Any, smooth: bool = False) -> Any:
    """A DataFrame with `time`, the sensor's components (x, y, …; SI), and `sensor` if there are several.

    Rows of one time (and sensor) are one scan. The same kind of DataFrame comes back: id, time, existence, confirmed,
    age, status, row (the plot's, null where there was none), the state's components and their sd. Tracks that
    were never confirmed are left out. Errors: ValueError.
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
