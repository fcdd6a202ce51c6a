"""`jink track -` as an object: rows in one by one, estimates out, predictions for any time, its state as bytes."""

from __future__ import annotations

import json
import math
import os
import pickle
from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any, Literal, Self

import numpy as np
import polars as pl

from ..catalogue.names import FilterName, KindName
from ..catalogue.targets import KINDS
from ..checks import items
from ..filters.axis_by_axis import AxisByAxis
from ..filters.bank import Bank
from ..io.conventions import Conventions
from ..io.geodesy import DevelopedFrame
from ..io.loading import Reading
from ..io.projections import with_grid
from ..io.text_tables import json_lines
from ..models.provenance import VERSION
from ..times import Time, moment
from .lag import Lag
from .live import LiveTracks
from .live_targets import Followed
from .manoeuvring import told
from .noise_level import parse_sensor_sd
from .output import tracks_table
from .placing import Placed
from .prepare import Settings, sites_of
from .unseen_heights import with_unseen

LATEST = 9e12  # seconds; microseconds are whole numbers of 64 bits
Value = float | int | str | bool | None
Row = dict[str, Value]

MAGIC = b"jink live tracker 1\n"
REJECTED = 1000  # rejected rows that are kept


class LiveTracker:
    """Targets that come and go, followed row by row; what ``jink track -`` does, from Python.

    kind: of the targets; filter: a name of ``jink.FILTERS`` or a filter, by default the kind's; sensor_sd: metres, or
    per component; site: latitude, longitude and altitude of a radar; gap (s): without a position for longer a target is
    forgotten, and begins a new part when it comes back (0: never). columns, altitude_unit, time_unit, axes,
    azimuth_from, crs and manoeuvre_g as for :func:`jink.track`. The measurement noise is the usual one of the kind
    unless sensor_sd says otherwise. lag: rows have columns ``lagged_…`` too, where the target was so many of its rows
    ago by all that came since; of a loaded state they know the rows since alone. Errors: InputError (a ValueError).
    """

    def __init__(
        self,
        kind: KindName = "aircraft",
        *,
        filter: FilterName | Bank | AxisByAxis | None = None,
        sensor_sd: float | str | Mapping[str, float] | None = None,
        site: tuple[float, ...] | None = None,
        gap: float | None = None,
        columns: Mapping[str, str] | None = None,
        altitude_unit: Literal["ft", "m"] | None = None,
        time_unit: Literal["s", "ms", "us", "ns"] | None = None,
        axes: Literal["enu", "ned"] | None = None,
        azimuth_from: Literal["north", "east", "grid"] | None = None,
        crs: str | None = None,
        manoeuvre_g: float | None = None,
        lag: int | None = None,
    ) -> None:
        alone, sites = sites_of({} if site is None else {"": site})
        settings = Settings(
            filter=filter,
            kind=kind,
            sensor_sd=parse_sensor_sd(sensor_sd),
            site=alone,
            sites=sites,
            gap=gap,
            manoeuvre_g=manoeuvre_g,
            lag=Lag.of(lag),
        )
        conventions = with_grid(Conventions(None, None, None, axes, azimuth_from, crs), alone, bool(sites))
        reading = Reading(columns, altitude_unit, time_unit, True, conventions, None)
        self.kind = kind
        self._tracks = LiveTracks(reading, settings, apart=True)
        self._rejected: deque[Row] = deque(maxlen=REJECTED)

    def __repr__(self) -> str:
        rows, lost = self._tracks.rows, self._tracks.rejected
        return f"LiveTracker({self.kind!r}: {len(self.targets)} targets, {rows:,} rows, {lost:,} rejected)"

    @property
    def targets(self) -> list[str]:
        """Names of the targets that are followed now."""
        return list(self._tracks.active)

    @property
    def notes(self) -> list[str]:
        """What was assumed or noticed, in sentences."""
        return list(self._tracks.notes)

    @property
    def rejected(self) -> list[Row]:
        """The last rows that were not used, each with its ``reason``; the last thousand of them."""
        return list(self._rejected)

    def update(self, target: str | int, time: Time, **measured: Value) -> Row | None:
        """One row: its target, its time (seconds, or a date), and columns such as lat=…, lon=…, or x=…, y=…

        Returns the estimate as a row of ``jink track -``: position, velocity, course, their sds, modes, status. None
        where the row was not used; ``rejected`` says why. A row of the target that waited for this one comes before it
        in :meth:`update_many`. Errors: InputError where the first row has no position that can be read.
        """
        rows = self.update_many([{"target": target, "time": time, **measured}])
        return rows[-1] if rows else None

    def update_many(self, rows: Iterable[Mapping[str, Value | datetime | np.datetime64]]) -> list[Row]:
        """Rows that have come together, each a mapping with target, time and position; the estimates, in order."""
        lines = [_line(row) for row in items("rows", rows, "mappings with target, time and position")]
        estimates, rejected = self._tracks.take(lines)
        self._rejected.extend(json.loads(line) for line in rejected.splitlines())
        return [json.loads(line) for line in estimates.splitlines()]

    def predict(self, time: Time) -> list[Row]:
        """Where every target that is followed will be at a time, with sds; the state is not touched.

        A target whose last row is later than this time is left out.
        """
        at = _seconds(time)
        if abs(at) > LATEST:
            raise ValueError(f"time: expected seconds that a date can have, got {at:g}")
        out: list[Row] = []
        for name, target in self._tracks.active.items():
            if target.slot is not None and target.last <= at:
                table = self._predicted(name, target, at)
                out += [json.loads(line) for line in json_lines(table).splitlines()]
        return out

    def save(self, path: str | Path | None = None) -> bytes:
        """The state as bytes, also written to a file; :meth:`load` goes on from it."""
        state = MAGIC + VERSION.encode() + b"\n" + pickle.dumps(self)
        if path is not None:
            Path(path).write_bytes(state)
        return state

    @classmethod
    def load(cls, state: bytes | str | Path) -> Self:
        """Go on from what :meth:`save` gave, of the same version of jink. Load only what you saved yourself: the bytes
        are a pickle, which can run code. Errors: ValueError for other bytes.
        """
        if not isinstance(state, bytes | str | os.PathLike) or (isinstance(state, str) and "\0" in state):
            raise TypeError(f"state: expected bytes or the name of a file, got {state!r:.60}")
        data = state if isinstance(state, bytes) else Path(state).read_bytes()
        if not data.startswith(MAGIC):
            raise ValueError("state: is no state of a LiveTracker; expected what its save() gave")
        version, _, body = data[len(MAGIC) :].partition(b"\n")
        if version.decode("ascii", "replace") != VERSION:
            raise ValueError(f"state: is of jink {version.decode('ascii', 'replace')}; expected {VERSION}")
        found = pickle.loads(body)
        if not isinstance(found, cls):
            raise ValueError(f"state: holds a {type(found).__name__}; expected a {cls.__name__}")
        return found

    def _predicted(self, name: str, target: Followed, at: float) -> pl.DataFrame:
        estimate = target.pool.singles[target.slot or 0].predict(at - target.began)
        modes = len(estimate.modes)
        known = {"mode_probability": np.full((1, modes), 1.0), "nis": np.array([math.nan]), "nis_dof": np.zeros(1)}
        estimate = replace(estimate, results={**known, **estimate.results})
        nothing = np.full((1, target.axes), np.nan)
        rows = pl.DataFrame({"target": [name], "part": [target.part], "time": [at], "file": [""], "row": [0]})
        names = ("x", "y", "z")[: target.axes]
        frame: Any = self._tracks.settings.site
        if target.anchor is not None:
            x, y, *_ = target.anchor
            ends = [np.array([value]) for value in (x, y, *target.anchor)]
            frame, names = DevelopedFrame(*ends), ("x", "y", "altitude")[: target.axes]
        first = np.array([True])
        plane, height = nothing[:, :2], np.array([math.nan])
        placed = Placed(rows, np.zeros(1), nothing, plane, height, first, target.axes, names, frame)
        placed = with_unseen(placed, [(at - target.vertical, math.inf)], KINDS[self._tracks.settings.kind].climbs)
        manoeuvres = told(estimate, np.zeros(1), first, target.pool.manoeuvres)
        table = tracks_table(placed, estimate, bool(self._tracks.lines.absolute), manoeuvres)
        measured = [column for column in table.columns if column.startswith(("measured_", "nis"))]
        return table.drop("file", "row", "segment", *measured)


def _line(row: Any) -> bytes:
    if not isinstance(row, Mapping):
        raise TypeError(f"rows: expected mappings with target, time and position, got {type(row).__name__}")
    named = {str(name): _plain(value) for name, value in row.items()}
    for name, value in named.items():
        if not isinstance(value, str | int | float | None):
            raise TypeError(f"{name}: expected a number, a text or a date, got {type(value).__name__}")
    return json.dumps(named).encode()


def _plain(value: Any) -> Value:
    """What JSON can hold."""
    if isinstance(value, datetime):
        return value.isoformat()
    if isinstance(value, np.datetime64):
        return f"{np.datetime_as_string(value, unit='us')}Z"
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _seconds(time: Time) -> float:
    """Seconds of a number or a date. Errors: ValueError for other text."""
    if not isinstance(time, str):
        return moment(time)
    try:
        return moment(datetime.fromisoformat(time))
    except ValueError:
        raise ValueError(f"time: expected seconds or a date such as 2026-05-01T12:00:00Z, got {time!r}") from None
