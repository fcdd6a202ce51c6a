"""Tracks that grow line by line: columns and units as in files, a live filter and a frame per target."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field, replace
from statistics import median_low
from types import SimpleNamespace
from typing import Any

import numpy as np
import polars as pl

from ..catalogue.targets import KINDS
from ..estimate import Estimate
from ..io.columns import Columns
from ..io.errors import InputError
from ..io.formats.json import JsonText
from ..io.geodesy import DevelopedFrame, onward
from ..io.loading import Reading, recognised
from ..io.measurements import Measurements, measure
from ..io.writing import plain_times
from .live_order import Order, Waiting, in_the_future
from .live_watch import Watch
from .noise_level import USUAL_ALTITUDE_SD, USUAL_POLAR_SD
from .output import OFF, ON, tracks_table
from .placing import Placed, lay
from .prepare import Pace, Settings, choose

STALE_SPEED = 5.0  # m/s: estimated speed above which a repeated position is an old one
STEPS = 64  # times between two rows of a target that tell the usual one
NAME = "standard input"
BACKWARDS = "time runs backwards"
Anchor = tuple[float, float, float, float, float]  # x, y, latitude, longitude, convergence


@dataclass
class Followed:
    """One target: its live filter, the place its frame has got to, and what it was last told."""

    filter: Any
    live: Any
    first: list[float]
    axes: int
    part: int
    began: float
    last: float
    positioned: float
    rows: int = 0
    place: tuple[float, ...] = ()
    anchor: Anchor | None = None
    speed: float = 0.0
    manoeuvring: bool | None = None
    segment: int = 0
    order: Order = field(default_factory=Order)
    watch: Watch = field(default_factory=Watch)
    parts: int = 1


@dataclass
class LiveTracks:
    """All targets of one stream."""

    reading: Reading
    settings: Settings
    followed: dict[str, Followed] = field(default_factory=dict)
    rows: int = 0
    rejected: int = 0
    notes: list[str] = field(default_factory=list)
    names: list[str] = field(default_factory=list)
    steps: list[float] = field(default_factory=list)
    filters: dict[tuple[int, Pace], Any] = field(default_factory=dict)

    @property
    def pace(self) -> Pace:
        """As the first steps of the stream tell it, to two digits."""
        step = median_low(self.steps) if self.steps else 0.0
        return Pace.of(float(f"{step:.2g}"), self.settings)

    def take(self, lines: list[bytes]) -> tuple[str, str]:
        """Estimates and rejected rows for some more lines, both as JSON Lines."""
        lines = [line for line in lines if line.strip()]
        first, self.rows = self.rows, self.rows + len(lines)
        measurements, refused = self._read(lines)
        if measurements is None:
            return "", self._refuse(refused, first)
        refused += [row for frame in measurements.rejected for row in frame.iter_rows(named=True)]
        used: list[pl.DataFrame] = []
        states: list[Any] = []
        rows = measurements.rows.with_columns(measured=_measured(measurements))
        third = next((n for n in ("altitude", "elevation", "z") if n in rows.columns), None)
        rows = rows.with_columns(pl.col("row") + first)
        for index, row in enumerate(rows.iter_rows(named=True)):
            ready, reasons = self._in_order(Waiting(row, rows[index : index + 1]), measurements.absolute)
            for waiting in ready:
                reason = self._step(waiting.row, measurements.position, third, states)
                reasons += [(waiting, reason)] if reason else []
                used += [] if reason else [waiting.table]
            refused += [_refused(waiting, reason, first) for waiting, reason in reasons]
        text = self._tables(pl.concat(used, how="diagonal"), states, measurements, third) if used else ""
        return text, self._refuse(refused, first)

    def finish(self) -> str:
        """Rejected rows that waited for others when the stream ended."""
        lost = [waiting for target in self.followed.values() for waiting in target.order.given_up()]
        return self._refuse([_refused(waiting, BACKWARDS, 0) for waiting in lost], 0)

    def _in_order(self, waiting: Waiting, absolute: bool) -> tuple[list[Waiting], list[tuple[Waiting, str]]]:
        """The rows to be used now, in their order, and those that are not, with the reason."""
        name, now = waiting.row["target"], waiting.row["time"]
        target = self.followed.get(name)
        if target is None or now > target.last or (now == target.last and not self.settings.drop_duplicates):
            if target is not None and in_the_future(now, target.last, absolute):
                return [], [(waiting, "time lies in the future")]
            lost = target.order.given_up() if target else []
            return [waiting], [(late, BACKWARDS) for late in lost]
        if now == target.last:
            return [], [(waiting, "time occurs twice")]
        before, gap = target.order.before, self.pace.gap
        if before is not None and target.rows == 1 and before.last < now <= before.positioned + gap:
            self._say(f"target {name}: one time lay {target.last - before.last:.6g} s ahead and was taken as wrong")
            before.parts = target.parts
            self.followed[name] = before
            return [waiting], []
        ready, lost = target.order.late(waiting)
        if ready:
            self._say(
                f"target {name}: time goes back by {target.last - now:.6g} s and on from there; a new part begins"
            )
        return ready, [(late, BACKWARDS) for late in lost]

    def _say(self, note: str) -> None:
        if note not in self.notes:
            self.notes.append(note)

    def _read(self, lines: list[bytes]) -> tuple[Measurements | None, list[dict[str, Any]]]:
        """Lines to measurements; the columns are those seen in the stream so far."""
        try:
            text = JsonText(NAME, b"\n".join(lines))
        except InputError:
            return None, [
                {"row": i, "reason": "not a JSON object", "value": _shown(line)} for i, line in enumerate(lines)
            ]
        self.names += [name for name in text.names if name not in self.names]
        columns, conventions, notes = recognised(NAME, self.names, self.reading)
        _known_units(columns)
        wanted = sorted({column.name for column in columns.roles.values()})
        frame, unreadable = text.read([name for name in wanted if name in text.names])
        frame = frame.with_columns(pl.lit(None).alias(name) for name in wanted if name not in text.names)
        reading = self.reading
        try:
            found = measure(
                NAME,
                frame,
                columns,
                altitude_unit=reading.altitude_unit,
                time_unit=reading.time_unit,
                check_coordinates=reading.check_coordinates,
                conventions=conventions,
                stream=True,
            )
        except InputError:  # no time in any of these lines
            refused = [{"row": row, "reason": "time is missing or unreadable"} for row in frame["row"]]
            return None, refused + list(unreadable.iter_rows(named=True))
        self.notes += [note for note in notes + found.notes if note not in self.notes]
        return found, list(unreadable.iter_rows(named=True))

    def _refuse(self, refused: list[dict[str, Any]], first: int) -> str:
        self.rejected += len(refused)
        texts = []
        for row in sorted(refused, key=lambda row: row["row"]):
            known = {key: value for key, value in row.items() if value is not None and key != "file"}
            texts.append(json.dumps(known | {"row": row["row"] + first, "status": "rejected"}, ensure_ascii=False))
        return "".join(text + "\n" for text in texts)

    def _step(self, row: dict[str, Any], position: str, third: str | None, states: list[Any]) -> str | None:
        """Give one row to its target's filter and append its state, or return why it cannot be used."""
        now, target = row["time"], self.followed.get(row["target"])
        measured = row["measured"]
        if target is not None and not target.order.ended:
            self._tell_pace(now - target.last)
        gap = self.pace.gap
        if target is None or target.order.ended or (gap > 0 and now - target.positioned > gap):
            if not measured:
                return "no position yet" if target is None else "no position for longer than the gap"
            axes = 3 if third and _finite(row[third]) and self._axes() != 2 else 2
            filter_ = self._filter(axes, position, third)
            part = target.parts if target else 0
            order = Order(before=target if target and not target.order.ended else None)
            target = Followed(filter_, filter_.start(1), [], axes, part, began=now, last=now, positioned=now)
            target.order, target.parts = order, part + 1
            self.followed[row["target"]] = target
        z = _measurement(row, position, third, target)
        if measured and self.settings.drop_stale and _stale(row, position, target):
            measured, z = False, [math.nan] * len(z)
        if target.rows == 0:
            target.first = z
        elif target.rows == 1:
            self._choose_anew(target, position, third)
        target.rows += 1
        states.append(_advance(target, row, now, z, measured, position))
        if self.settings.check:
            for warning in target.watch.look(row["target"], states[-1].status, target.speed, self.settings.kind):
                self._say(warning)
        return None

    def _tell_pace(self, step: float) -> None:
        """A time between two rows of a target; the first is believed, further ones that are gaps are none."""
        if step > 0 and len(self.steps) < STEPS and (not self.steps or step <= self.pace.wait):
            self.steps.append(step)

    def _choose_anew(self, target: Followed, position: str, third: str | None) -> None:
        """At the second row the usual step is known, which some filters have probabilities for: begin again with
        that.
        """
        filter_ = self._filter(target.axes, position, third)
        if filter_ is not target.filter:
            target.filter, target.live = filter_, filter_.start(1)
            target.live.update(0.0, np.array([target.first]))

    def _axes(self) -> int | None:
        return getattr(self.settings.filter, "axes", None)

    def _filter(self, axes: int, position: str, third: str | None) -> Any:
        pace = self.pace
        if (axes, pace) not in self.filters:
            given = self.settings.sensor_sd
            names = {"geographic": ("x", "y", "altitude"), "cartesian": ("x", "y", "z")}
            components = names.get(position, ("range", "azimuth", third or ""))[:axes]
            usual = _usual(given, self.settings.kind)
            _, self.filters[axes, pace] = choose(components, usual, pace, self.settings)
            note = "measurement noise cannot be estimated from a stream: the usual value is taken; --sensor-sd sets it"
            if not given and self.settings.filter is None and note not in self.notes:
                self.notes.append(note)
        return self.filters[axes, pace]

    def _tables(self, rows: pl.DataFrame, states: list[Any], measurements: Measurements, third: str | None) -> str:
        """Estimates of rows of two or three axes as JSON Lines in the order in which they came."""
        tables = []
        for axes in sorted({state.axes for state in states}):
            which = np.array([state.axes == axes for state in states])
            some = [state for state in states if state.axes == axes]
            part = rows.filter(pl.Series(which)).with_columns(part=pl.Series([s.part for s in some], dtype=pl.Int32))
            site = None if measurements.position == "geographic" else self.settings.site
            placed = lay(part, measurements.position, site, axes, third if axes == 3 else None)
            table = tracks_table(_moved(placed, some), _joined(some), measurements.absolute)
            tables.append(table.with_columns(segment=pl.Series([s.segment for s in some], dtype=pl.Int32)))
        table = pl.concat(tables, how="diagonal").sort("row").drop("file")
        return plain_times(table).write_ndjson()


def _known_units(columns: Columns) -> None:
    for role in ("azimuth", "elevation"):
        column = columns.roles.get(role)
        if column is not None and column.unit is None:
            raise InputError(
                f"{NAME}: a stream needs the unit of {role}; --columns {role}_deg={column.name} (or {role}_rad)"
            )


def _usual(given: dict[str, float], kind: str) -> dict[str, float]:
    return USUAL_POLAR_SD | {"position": KINDS[kind].position_sd, "altitude": given.get("z", USUAL_ALTITUDE_SD)} | given


def _measured(measurements: Measurements) -> pl.Series:
    from .cleaning import measured_rows

    return measured_rows(measurements.rows, measurements.position)


def _finite(value: float | None) -> bool:
    return value is not None and math.isfinite(value)


def _refused(waiting: Waiting, reason: str, first: int) -> dict[str, Any]:
    row = waiting.row
    return {"row": row["row"] - first, "target": row["target"], "reason": reason}


def _shown(line: bytes) -> str:
    return line[:80].decode("utf-8", errors="replace")


def _stale(row: dict[str, Any], position: str, target: Followed) -> bool:
    """The same position again while the target moves by its estimate and does not rest by its report."""
    place = tuple(
        row[name]
        for name in {"geographic": ("latitude", "longitude"), "polar": ("range", "azimuth")}.get(position, ("x", "y"))
    )
    same, target.place = place == target.place, place
    resting = _finite(row["speed"]) and row["speed"] <= 0.5
    return same and target.speed > STALE_SPEED and not resting


def _measurement(row: dict[str, Any], position: str, third: str | None, target: Followed) -> list[float]:
    """The row's z; a geographic position moves the target's frame on by one geodesic."""
    vertical = (
        [row[third] if _finite(row[third]) else math.nan]
        if third and target.axes == 3
        else [math.nan] * (target.axes - 2)
    )
    if position != "geographic":
        first, second = ("range", "azimuth") if position == "polar" else ("x", "y")
        return [row[first], row[second], *vertical]
    if not row["measured"]:
        return [math.nan, math.nan, *vertical]
    latitude, longitude = row["latitude"], row["longitude"]
    if target.anchor is None:
        target.anchor = (0.0, 0.0, latitude, longitude, 0.0)
    else:
        x, y, before, beside, convergence = target.anchor
        east, north, convergence = onward(before, beside, convergence, latitude, longitude)
        target.anchor = (x + east, y + north, latitude, longitude, convergence)
    x, y = target.anchor[:2]
    return [x, y, *vertical]


def _advance(target: Followed, row: dict[str, Any], now: float, z: list[float], measured: bool, position: str) -> Any:
    """Update the live filter and remember what the next row needs."""
    estimate = target.live.update(now - target.began, np.array([z]))
    index = {name: i for i, name in enumerate(estimate.components)}
    x = estimate.x[0].copy()
    target.speed = math.hypot(x[index["vx"]], x[index["vy"]])
    target.last, target.positioned = now, now if measured else target.positioned
    if any(estimate.non_manoeuvring):
        level = bool(estimate.manoeuvring[0] > (OFF if target.manoeuvring else ON))
        target.segment += target.manoeuvring is not None and level != target.manoeuvring
        target.manoeuvring = level
    return SimpleNamespace(
        estimate=estimate,
        axes=target.axes,
        part=target.part,
        anchor=target.anchor,
        z=z,
        x=x,
        P=estimate.P[0].copy(),
        segment=target.segment if any(estimate.non_manoeuvring) else None,
        mode_probability=estimate.mode_probability[0].copy(),
        nis=estimate.nis[0],
        nis_dof=estimate.nis_dof[0],
        status=estimate.status[0],
    )


def _moved(placed: Placed, states: list[Any]) -> Placed:
    """The batch's rows in the frames that the targets have got to."""
    z = np.array([state.z for state in states])
    if not isinstance(placed.frame, DevelopedFrame):
        return replace(placed, z=z)
    anchors = np.array([state.anchor for state in states])
    frame = DevelopedFrame(z[:, 0], z[:, 1], *anchors.T)
    return replace(placed, z=z, plane=z[:, :2], height=z[:, 2] if z.shape[1] > 2 else placed.height, frame=frame)


def _joined(states: list[Any]) -> Estimate:
    """The states of filters that differ in their numbers at most."""
    stacked = {
        name: np.array([getattr(state, name) for state in states])
        for name in ("x", "P", "mode_probability", "nis", "nis_dof", "status")
    }
    return replace(states[0].estimate, results=stacked)
