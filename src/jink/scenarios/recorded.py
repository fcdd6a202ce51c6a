"""A scenario from recorded data: smoothed tracks as truth, seen by a simulated radar or any other sensor."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import numpy as np

from ..catalogue.names import KindName
from ..checks import Array, positive
from ..frozen import frozen
from ..io.errors import InputError
from ..metrics.draws import Draws
from .scenario import Scenario
from .sensing import RADARS, Schedule
from .truth import Kinematics

GAP = 30.0  # s without a row that no spline should bridge
KNOT = 2.0  # s between the points that a spline goes through, at least


@frozen
class Spline:
    """The natural cubic spline through points (K, axes) at times (K,): twice continuously differentiable."""

    time: Array
    points: Array
    bend: Array

    @classmethod
    def through(cls, time: Array, points: Array) -> Spline:
        """Second derivatives m by h₋ m₋ + 2 (h₋ + h₊) m + h₊ m₊ = 6 (slope₊ − slope₋), 0 at the ends."""
        h = np.diff(time)
        slope = np.diff(points, axis=0) / h[:, None]
        diagonal, right = 2.0 * (h[:-1] + h[1:]), 6.0 * np.diff(slope, axis=0)
        for k in range(1, len(diagonal)):
            share = h[k] / diagonal[k - 1]
            diagonal[k] -= share * h[k]
            right[k] -= share * right[k - 1]
        bend = np.zeros(points.shape)
        for k in range(len(diagonal) - 1, -1, -1):
            bend[k + 1] = (right[k] - h[k + 1] * bend[k + 2]) / diagonal[k]
        return cls(time, points, bend)

    def at(self, time: Array) -> Kinematics:
        """Kinematics (n, axes) at the times (n,)."""
        k = np.clip(np.searchsorted(self.time, time, side="right") - 1, 0, len(self.time) - 2)
        h = (self.time[k + 1] - self.time[k])[:, None]
        since = (time - self.time[k])[:, None]
        m, change = self.bend[k], self.bend[k + 1] - self.bend[k]
        slope = (self.points[k + 1] - self.points[k]) / h - h * (2.0 * m + self.bend[k + 1]) / 6.0
        position = self.points[k] + since * (slope + since * (0.5 * m + since * change / (6.0 * h)))
        return Kinematics(position, slope + since * (m + 0.5 * since * change / h), m + since * change / h)


@frozen
class Windows:
    """Truth of B runs: a window of `spline[b]` from time `begin[b]`, moved by `shift[b]` (axes)."""

    splines: list[Spline]
    begin: Array
    shift: Array

    @property
    def runs(self) -> int:
        """B"""
        return len(self.splines)

    def at(self, time: Array) -> Kinematics:
        """Kinematics at the times (B, n)."""
        each = [s.at(own + t) for s, own, t in zip(self.splines, self.begin, self._own(time), strict=True)]
        position, velocity, acceleration = (np.stack(arrays) for arrays in zip(*each, strict=True))
        return Kinematics(position + self.shift[:, None, :], velocity, acceleration)

    def breaks(self) -> Array:
        """(B, K) the splines' knots; the last one repeated where a spline has fewer."""
        most = max(len(s.time) for s in self.splines)
        rows = [np.pad(s.time, (0, most - len(s.time)), mode="edge") for s in self.splines]
        return np.stack(rows) - self.begin[:, None]

    def _own(self, time: Array) -> Array:
        return np.broadcast_to(time, (self.runs, time.shape[1]))


@frozen
class Recorded:
    """Run r takes flight r modulo their number: a random window of it, moved to a random place.

    flights; duration (s) of the window; distance (m), the range from the origin uniform between the two
    figures.
    """

    flights: tuple[Spline, ...]
    duration: float
    distance: tuple[float, float]

    def __call__(self, draws: Draws) -> Windows:
        splines = [self.flights[run % len(self.flights)] for run in draws.runs]
        spare = np.array([s.time[-1] - s.time[0] - self.duration for s in splines])
        begin = np.array([s.time[0] for s in splines]) + draws.uniform(0.0, 1.0) * spare
        away, azimuth = draws.uniform(*self.distance), draws.uniform(0.0, 2 * np.pi)
        half = 0.5 * self.duration
        middle = np.stack([s.at(np.array([b + half])).position[0] for s, b in zip(splines, begin, strict=True)])
        shift = np.zeros(middle.shape)
        shift[:, 0] = away * np.sin(azimuth) - middle[:, 0]
        shift[:, 1] = away * np.cos(azimuth) - middle[:, 1]
        return Windows(splines, begin, shift)


def recorded(
    data: Any,
    *,
    kind: str = "aircraft",
    duration: float = 300.0,
    distance: tuple[float, float] = (20e3, 120e3),
    name: str | None = None,
    **options: Any,
) -> Scenario:
    """Smoothed tracks of real targets as truth, by default seen by a 4 s radar at the origin.

    data a file, several, or a DataFrame, as for :func:`jink.track`, to which kind and options go; duration
    (s) of every run; distance (m) of the middle of a run from the radar. Heights are those of the data.
    Errors: InputError if no track is long enough.
    """
    from ..tracking.batch import track

    tracks = track(data, kind=cast(KindName, kind), smooth=True, details=True, **options).tracks
    flights = tuple(_flights(tracks, positive("duration", duration)))
    axes = flights[0].points.shape[1]
    observation, interval, jitter = RADARS["radar-4s"]
    schedule = Schedule(
        start=jitter, interval=interval, count=int((duration - 2 * jitter) / interval) + 1, jitter=jitter
    )
    return Scenario(
        name=name or (Path(data).name if isinstance(data, str | Path) else "recorded"),
        summary=f"{len(flights)} recorded tracks, smoothed, in windows of {duration:g} s",
        truth=Recorded(flights, duration, distance),
        observation=observation,
        schedule=schedule,
        axes=axes,
        kind=kind,
        source="recorded data, smoothed by jink.track",
    )


def _flights(tracks: Any, duration: float) -> Iterator[Spline]:
    """Stretches of tracks without restart or gap that last at least `duration`."""
    import polars as pl

    tracks = pl.DataFrame(tracks)
    vertical = next((c for c in ("altitude", "z") if c in tracks.columns and tracks[c].is_not_null().all()), None)
    longest, found = 0.0, False
    for _, rows in tracks.group_by(["target", "part"], maintain_order=True):
        rows = rows.filter(pl.col("x").is_not_nan() & pl.col("x").is_not_null())
        time, restarted = _seconds(rows["time"]), (rows["status"] == "restarted").to_numpy()
        points = rows.select("x", "y", *([vertical] if vertical else [])).to_numpy().astype(float)
        new = np.flatnonzero((np.diff(time, prepend=time[:1]) > GAP) | restarted)
        for first, last in zip([0, *new], [*new, len(time)], strict=True):
            kept = _thinned(time[first:last]) + first
            length = time[kept[-1]] - time[kept[0]] if len(kept) > 3 else 0.0
            longest = max(longest, length)
            if len(kept) > 3 and length >= duration:
                found = True
                yield Spline.through(time[kept] - time[kept[0]], points[kept])
    if not found:
        raise InputError(
            f"expected a track that lasts {duration:g} s without a gap of more than {GAP:g} s; "
            f"the longest lasts {longest:.0f} s"
        )


def _seconds(time: Any) -> Array:
    import polars as pl

    if isinstance(time.dtype, pl.Datetime):
        return time.dt.epoch("us").to_numpy() / 1e6
    return time.to_numpy().astype(float)


def _thinned(time: Array) -> np.ndarray:
    """Numbers of rows that are at least KNOT apart."""
    kept, last = [], -np.inf
    for row, t in enumerate(time):
        if t - last >= KNOT:
            kept.append(row)
            last = t
    return np.array(kept, dtype=np.intp)
