"""Tracks that grow line by line: columns and units as in files, a slot of a live filter and a frame per target.

The lines that are there together are taken together: each is put in its order, then the filters get all rows at once.
A row that needs an estimate that is still to come (a position that repeats) makes those before it come first.
"""

from __future__ import annotations

import json
import math
from collections import deque
from dataclasses import dataclass, field, replace
from statistics import median_low
from typing import Any

import numpy as np
import polars as pl

from ..catalogue.targets import KINDS
from ..estimate import Estimate
from ..io.errors import InputError
from ..io.evidence import distances
from ..io.geodesy import DevelopedFrame
from ..io.loading import Reading
from ..io.measurements import Measurements
from ..io.text_tables import json_lines
from .cleaning import STALE_SPEED, STALE_SPEED_AT_END, measured_rows
from .ground import least_heights
from .live_lagged import OUTPUTS as LAGGED
from .live_lagged import Delayed, lagged_table, scans_of
from .live_lines import Lines
from .live_manoeuvres import Past, columns
from .live_order import Order, Waiting, tomorrow
from .live_targets import OUTPUTS, Answered, Entry, Followed, Pool, answer_entries
from .manoeuvring import Manoeuvres
from .noise_level import USUAL_ALTITUDE_SD, USUAL_POLAR_SD
from .output import tracks_table
from .placing import Placed, heights_at, lay
from .prepare import Pace, Settings, choose
from .unknown_height import TargetHeight, height_of, on_the_ground
from .unseen_heights import with_unseen

STEPS = 64  # times between two rows of a target that tell the usual one
LATEST = 64  # rows whose median time is the stream's clock
BACKWARDS = "time runs backwards"
THIRD = ("altitude", "elevation", "z")
PLANE = {"geographic": ("latitude", "longitude"), "polar": ("range", "azimuth"), "cartesian": ("x", "y")}


@dataclass
class LiveTracks:
    """All targets of one stream."""

    reading: Reading
    settings: Settings
    followed: dict[str, Followed] = field(default_factory=dict)
    rows: int = 0
    rejected: int = 0
    notes: list[str] = field(default_factory=list)
    steps: list[float] = field(default_factory=list)
    pools: dict[tuple[int, Pace], Pool] = field(default_factory=dict)
    apart: bool = False  # every target has a filter of its own, which can predict and be saved

    def __post_init__(self) -> None:
        scans_of(self.settings.lag)
        if self.settings.sites:
            raise InputError("site: a stream takes one site, without a name; give plots of several radars as a file")
        self.lines = Lines(self.reading, notes=self.notes)
        self.pace = Pace.of(0.0, self.settings)
        self.active: dict[str, Followed] = {}  # those that have a slot
        self.clock: float | None = None
        self.swept = -math.inf
        self.ground = math.nan
        self._times: deque[float] = deque(maxlen=LATEST)
        self._pending: list[Entry] = []
        self._answered: list[Answered] = []
        self._target_height: TargetHeight | None = None
        self._leaving: list[tuple[Pool, int]] = []

    def take(self, lines: list[bytes]) -> tuple[str, str]:
        """Estimates and rejected rows for some more lines, both as JSON Lines."""
        lines = [line for line in lines if line.strip()]
        first, self.rows = self.rows, self.rows + len(lines)
        measurements, refused = self.lines.read(lines)
        if measurements is None:
            return "", self._refuse(refused, first)
        refused += [row for frame in measurements.rejected for row in frame.iter_rows(named=True)]
        position = measurements.position
        rows = measurements.rows.with_columns(
            pl.col("row") + first, measured=measured_rows(measurements.rows, position)
        )
        third = next((name for name in THIRD if name in rows.columns), None)
        names = ["target", "time", "row", "speed", "measured", *PLANE[position], *([third] if third else [])]
        late = tomorrow() if measurements.absolute else math.inf
        for index, row in enumerate(self._heights(rows.select(names), position, third).iter_rows(named=True)):
            ready, reasons = self._in_order(row, rows, index, late)
            for waiting in ready:
                reason = self._step(waiting, index, position, third)
                reasons += [(waiting.row if isinstance(waiting, Waiting) else waiting, reason)] if reason else []
            refused += [_refused(given, reason, first) for given, reason in reasons]
        self._flush()
        self._clock(rows["time"])
        refused += [_refused(row, BACKWARDS, first) for row in self._forget()]
        return self._text(rows, measurements, third), self._refuse(refused, first)

    def _heights(self, rows: pl.DataFrame, position: str, third: str | None) -> pl.DataFrame:
        """The rows with altitudes of a radar's plots as heights at its site, which its filter measures."""
        if position != "polar" or third != "altitude":
            return rows
        seen = (rows[name].to_numpy() for name in ("range", "azimuth", "altitude"))
        return rows.with_columns(altitude=heights_at(self.settings.site, *seen))

    def finish(self) -> str:
        """Rejected rows that waited for others when the stream ended."""
        lost = [waiting.row for target in self.followed.values() for waiting in target.order.given_up()]
        return self._refuse([_refused(row, BACKWARDS, 0) for row in lost], 0)

    def _in_order(
        self, row: dict[str, Any], rows: pl.DataFrame, index: int, late: float
    ) -> tuple[list[Any], list[tuple[dict[str, Any], str]]]:
        """The rows to be used now, in their order, and those that are not, with the reason. late: the first time that
        lies in the future.
        """
        now = row["time"]
        target = self.followed.get(row["target"])
        last = target.last if target is not None else self.clock
        if now > late and last is not None and last <= late:
            return [], [(row, "time lies in the future")]
        if target is None or now > target.last or (now == target.last and not self.settings.drop_duplicates):
            lost = target.order.given_up() if target is not None and target.order.waiting else []
            return [row], [(waiting.row, BACKWARDS) for waiting in lost]
        if now == target.last:
            return [], [(row, "time occurs twice")]
        before, gap = target.order.before, self.pace.gap
        if before is not None and target.rows == 1 and before.last < now <= before.positioned + gap:
            name = row["target"]
            self._say(f"target {name}: one time lay {target.last - before.last:.6g} s ahead and was taken as wrong")
            before.parts = target.parts
            self._leave(target)
            self.followed[name] = self.active[name] = before
            return [row], []
        ready, lost = target.order.late(Waiting(row, rows[index : index + 1]))
        if ready:
            self._say(
                f"target {row['target']}: time goes back by {target.last - now:.6g} s and on from there; "
                "a new part begins"
            )
        return list(ready), [(waiting.row, BACKWARDS) for waiting in lost]

    def _say(self, note: str) -> None:
        if note not in self.notes:
            self.notes.append(note)

    def _refuse(self, refused: list[dict[str, Any]], first: int) -> str:
        self.rejected += len(refused)
        texts = []
        for row in sorted(refused, key=lambda row: row["row"]):
            known = {key: value for key, value in row.items() if value is not None and key != "file"}
            texts.append(json.dumps(known | {"row": row["row"] + first, "status": "rejected"}, ensure_ascii=False))
        return "".join(text + "\n" for text in texts)

    def _step(self, given: Any, index: int, position: str, third: str | None) -> str | None:
        """Put one row on its way to its target's filter, or return why it cannot be used."""
        row, table = (given.row, given.table) if isinstance(given, Waiting) else (given, None)
        now, name, measured = row["time"], row["target"], row["measured"]
        target = self.followed.get(name)
        if target is not None and not target.order.ended:
            self._tell_pace(now - target.last)
        gap = self.pace.gap
        anew = target is None or target.slot is None or target.order.ended
        if anew or (gap > 0 and now - target.positioned > gap):  # type: ignore[union-attr]
            if not measured:
                return "no position yet" if target is None else "no position for longer than the gap"
            target = self._begin(name, now, target, _finite(row[third]) if third else False, position, third)
        assert target is not None
        high = measured and third is not None and _finite(row[third])
        if high and target.axes == 2 and self._axes() != 2:
            self._in_space(target, position, third)
        here = (row["latitude"], row["longitude"]) if position == "geographic" and measured else None
        z = _measurement(row, position, third, target.axes)
        if position == "polar" and target.axes == 2 and not (height := self._height()).is_ground:
            z[0] = float(height.ground_range(np.array([z[0]]))[0][0])
        if measured and self.settings.drop_stale and self._stale(row, position, target):
            measured, here, z = False, None, [math.nan] * len(z)
        if target.rows == 0:
            target.first = [0.0, 0.0, *z[2:]] if here is not None else z
        elif target.rows == 1:
            self._choose_anew(name, target, position, third)
        target.rows += 1
        assert target.slot is not None
        entry = Entry(target, name, target.pool, target.slot, now - target.began, z, index, row["row"], table)
        if here is not None:
            entry.before, entry.here, target.where = target.where, here, here
        target.last, target.positioned = now, now if measured else target.positioned
        if target.axes == 3:
            target.vertical = now if _finite(z[2]) else target.vertical
            entry.unseen = now - target.vertical
        target.fresh = True
        self._wait(entry)
        return None

    def _begin(
        self, name: str, now: float, target: Followed | None, high: bool, position: str, third: str | None
    ) -> Followed:
        """A new part of a target, or its first."""
        pool = self._pool(3 if high and self._axes() != 2 else 2, position, third)
        axes = 3 if high and self._axes() != 2 else 2
        part = target.parts if target is not None else 0
        new = Followed(pool, pool.take(), axes, part, began=now, last=now, positioned=now, parts=part + 1)
        if target is not None:
            self._settle(target)
            if target.order.ended:
                self._leave(target)
            elif target.slot is not None:
                new.order.before = target
        self.followed[name] = self.active[name] = new
        return new

    def _stale(self, row: dict[str, Any], position: str, target: Followed) -> bool:
        """The same position again while the target moves and does not rest by its report.

        It moves by its estimate, or by its last two places: a filter that begins with one position twice does not.
        """
        first, second = PLANE[position]
        place = (row[first], row[second])
        if place != target.place:
            target.left, target.place = (target.place, row["time"] - target.since), place
            target.since = row["time"]
            return False
        if _finite(row["speed"]) and row["speed"] <= STALE_SPEED:
            return False
        if target.waiting:
            self._flush()
        return target.speed > STALE_SPEED_AT_END or _pace(target, position) > STALE_SPEED_AT_END

    def _tell_pace(self, step: float) -> None:
        """A time between two rows of a target; the first is believed, further ones that are gaps are none."""
        if step > 0 and len(self.steps) < STEPS and (not self.steps or step <= self.pace.wait):
            self.steps.append(step)
            # as the first steps of the stream tell it, to two digits
            self.pace = Pace.of(float(f"{median_low(self.steps):.2g}"), self.settings)

    def _choose_anew(self, name: str, target: Followed, position: str, third: str | None) -> None:
        """At the second row the usual step is known, which some filters have probabilities for: begin again with
        that.
        """
        self._settle(target)
        pool = self._pool(target.axes, position, third)
        if pool is not target.pool:
            self._leave(target)
            target.pool, target.slot = pool, pool.take()
            self.active[name] = target
            self._wait(Entry(target, name, pool, target.slot, 0.0, target.first, 0, 0, silent=True))

    def _in_space(self, target: Followed, position: str, third: str | None) -> None:
        """The first height of a target that was followed in the plane: its filter begins again, with three axes."""
        self._leave(target)
        self._flush()
        target.axes, target.pool = 3, self._pool(3, position, third)
        target.slot = target.pool.take()
        target.past, target.delayed = Past(segments=target.past.segments), Delayed()

    def _wait(self, entry: Entry) -> None:
        entry.target.waiting += 1
        self._pending.append(entry)

    def _flush(self) -> None:
        """Let the filters have the rows that wait, and give back the slots of targets that have gone."""
        if self._pending:
            answered = answer_entries(self._pending)
            self._pending = []
            self._answered += answered
            for some in answered if self.settings.check else ():
                self._watch(some)
        for pool, slot in self._leaving:
            pool.release(slot)
        self._leaving = []

    def _watch(self, some: Answered) -> None:
        x, (first, second) = some.estimate.x, some.entries[0].pool.velocity
        speeds = np.hypot(x[:, first], x[:, second]).tolist()
        for entry, status, speed in zip(some.entries, some.estimate.status.tolist(), speeds, strict=True):
            for warning in entry.target.watch.look(entry.name, status, speed, self.settings.kind):
                self._say(warning)

    def _settle(self, target: Followed) -> None:
        """The part before the latest one is over."""
        if target.order.before is not None:
            self._leave(target.order.before)
            target.order.before = None

    def _leave(self, target: Followed) -> None:
        """Its slot is free as soon as the rows that wait have been told."""
        if target.slot is not None:
            self._leaving.append((target.pool, target.slot))
            target.slot = None

    def _clock(self, times: pl.Series) -> None:
        """The stream's clock is the median time of its last rows, which one wrong stamp does not move."""
        self._times.extend(times.tail(LATEST).to_list())
        if self._times:
            self.clock = median_low(self._times)

    def _forget(self) -> list[dict[str, Any]]:
        """Free the slots of targets that were not heard of for longer than the gap; returns rows that waited."""
        gap, clock = self.pace.gap, self.clock
        if gap <= 0 or clock is None or abs(clock - self.swept) < 0.25 * gap:
            return []
        self.swept = clock
        lost: list[dict[str, Any]] = []
        for name, target in list(self.active.items()):
            # since the sweep before; the clock of the stream may be set back
            target.heard = clock if target.fresh else min(target.heard, clock)
            target.fresh = False
            if clock - target.heard > gap:
                lost += [waiting.row for waiting in target.order.given_up()]
                self._settle(target)
                self._leave(target)
                target.order = Order()
                del self.active[name]
        self._flush()
        return lost

    def _height(self) -> TargetHeight:
        """Of targets without heights; what is taken for granted is noted once."""
        if self._target_height is None:
            columns = self.lines.columns
            name = columns.roles["range"].name if columns is not None and "range" in columns.roles else ""
            given = self.settings.target_height
            self._target_height, words = height_of(given, self.settings.kind, name, False)
            if words:
                self._say(words)
        return self._target_height

    def _axes(self) -> int | None:
        return getattr(self.settings.filter, "axes", None)

    def _pool(self, axes: int, position: str, third: str | None) -> Pool:
        pace = self.pace
        if (axes, pace) not in self.pools:
            given = self.settings.sensor_sd
            names = {"geographic": ("x", "y", "altitude"), "cartesian": ("x", "y", "z")}
            components = names.get(position, ("range", "azimuth", third or ""))[:axes]
            usual = _usual(given, self.settings.kind)
            filter = choose(components, usual, pace, self.settings)[1]
            what = Manoeuvres.of(filter, self.settings.kind, self.settings.manoeuvre_g)
            self.pools[axes, pace] = Pool(filter, what, axes, self.apart, scans_of(self.settings.lag))
            note = "measurement noise cannot be estimated from a stream: the usual value is taken; --sensor-sd sets it"
            if not given and self.settings.filter is None:
                self._say(note)
        return self.pools[axes, pace]

    def _text(self, rows: pl.DataFrame, measurements: Measurements, third: str | None) -> str:
        """Estimates of rows of two or three axes as JSON Lines in the order in which they came."""
        answered, self._answered = self._answered, []
        tables = []
        for axes in (2, 3):
            some = [each for each in answered if each.entries[0].pool.axes == axes]
            if some:
                tables.append(self._table(rows, some, axes, measurements, third))
        if not tables:
            return ""
        table = tables[0] if len(tables) == 1 else pl.concat(tables, how="diagonal")
        return json_lines(table.sort("row").drop("file"))

    def _table(
        self, rows: pl.DataFrame, some: list[Answered], axes: int, measurements: Measurements, third: str | None
    ) -> pl.DataFrame:
        entries = [entry for each in some for entry in each.entries]
        estimate = _joined([each.estimate for each in some])
        part = pl.Series("part", [entry.target.part for entry in entries], dtype=pl.Int32)
        z = np.array([entry.z for entry in entries])
        placed = self._placed(_rows_of(rows, entries).with_columns(part), z, entries, axes, measurements, third)
        placed = with_unseen(placed, [(entry.unseen, math.inf) for entry in entries], KINDS[self.settings.kind].climbs)
        manoeuvres = columns([entry.told for entry in entries if entry.told is not None])
        table = tracks_table(placed, estimate, measurements.absolute, manoeuvres, self._lowest(placed))
        late = [each.lagged for each in some if each.lagged is not None]
        if not late:
            return table
        lagged = lagged_table(
            _joined(late, LAGGED),
            [entry.behind for entry in entries],
            [entry.delayed for entry in entries],
            axes=axes,
            site=self.settings.site,
            absolute=measurements.absolute,
            manoeuvres=some[0].entries[0].pool.manoeuvres,
            climbs=KINDS[self.settings.kind].climbs,
            ground=self.ground,
        )
        return table if lagged is None else pl.concat([table, lagged], how="horizontal")

    def _lowest(self, placed: Placed) -> np.ndarray:
        """The ground of each row (N,), as the stream has shown it up to there."""
        if placed.axes < 3:
            return np.full(placed.time.size, np.nan)
        sd = _usual(self.settings.sensor_sd, self.settings.kind)["altitude"]
        order = np.argsort(placed.rows["row"].to_numpy(), kind="stable")
        least = least_heights(placed, sd**2)[order]
        lowest = np.fmin.accumulate(np.r_[self.ground, least])[1:]
        self.ground = float(lowest[-1])
        return lowest[np.argsort(order)]

    def _placed(
        self,
        rows: pl.DataFrame,
        z: np.ndarray,
        entries: list[Entry],
        axes: int,
        measurements: Measurements,
        third: str | None,
    ) -> Placed:
        """The rows in the frames that the targets have got to."""
        new = np.arange(len(entries)) == 0
        if measurements.position != "geographic":
            placed = lay(rows, measurements.position, self.settings.site, axes, third if axes == 3 else None)
            if measurements.position == "polar" and axes == 2 and not (height := self._height()).is_ground:
                placed = on_the_ground(placed, height)
            return replace(placed, z=z)
        anchors = np.array([entry.anchor for entry in entries])
        frame = DevelopedFrame(z[:, 0], z[:, 1], *anchors.T)
        height = z[:, 2] if axes > 2 else np.full(len(z), np.nan)
        names = ("x", "y", "altitude")[:axes]
        return Placed(rows, np.zeros(len(z)), z, z[:, :2], height, new, axes, names, frame)


def _rows_of(rows: pl.DataFrame, entries: list[Entry]) -> pl.DataFrame:
    """The entries' rows of measurements, in their order."""
    now = rows[[entry.index for entry in entries]]
    late = {place: entry.table for place, entry in enumerate(entries) if entry.table is not None}
    if not late:
        return now
    pieces, done = [], 0
    for place, table in late.items():
        pieces += [now[done:place], table]
        done = place + 1
    return pl.concat([*pieces, now[done:]], how="diagonal")


def _usual(given: dict[str, float], kind: str) -> dict[str, float]:
    return USUAL_POLAR_SD | {"position": KINDS[kind].position_sd, "altitude": given.get("z", USUAL_ALTITUDE_SD)} | given


def _pace(target: Followed, position: str) -> float:
    """m/s between the last two places of a target; 0 where there is one."""
    place, seconds = target.left
    if not place or not seconds > 0:
        return 0.0
    first, second = np.array([place, target.place]).T
    return float(distances(first, second, position)[0]) / seconds


def _finite(value: float | None) -> bool:
    return value is not None and math.isfinite(value)


def _refused(row: dict[str, Any], reason: str, first: int) -> dict[str, Any]:
    return {"row": row["row"] - first, "target": row["target"], "reason": reason}


def _measurement(row: dict[str, Any], position: str, third: str | None, axes: int) -> list[float]:
    """The row's z; of a geographic position x and y follow when its frame has moved on to it."""
    vertical = [math.nan] * (axes - 2)
    if third and axes == 3 and _finite(row[third]):
        vertical = [row[third]]
    if position == "geographic":
        return [math.nan, math.nan, *vertical]
    first, second = PLANE[position]
    return [row[first], row[second], *vertical]


def _joined(estimates: list[Estimate], outputs: tuple[str, ...] = OUTPUTS) -> Estimate:
    """The estimates of filters that differ in their numbers at most."""
    if len(estimates) == 1:
        return estimates[0]
    stacked = {name: np.concatenate([each.results[name] for each in estimates]) for name in outputs}
    return replace(estimates[0], results=stacked)
