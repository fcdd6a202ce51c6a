"""What was done and found in shares of a large table, added up; as JSON, so that another process can go on from it."""

from __future__ import annotations

import base64
import io
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any

import polars as pl

from ..io.measurements import Measurements
from ..io.rejected import SCHEMA
from .finding import as_dicts
from .output import NisCounts
from .plausibility import findings
from .prepare import Known, Settings
from .seen import Seen
from .summary import in_the_plane, not_corrected, own_noise, plain, reasons, words_for

SLIM = ("target", "part", "time", "status", "speed", "acceleration_x", "acceleration_y", "measured_x", "measured_y")
KNOWN = ("x", "measured_z", "nis")  # columns of which the checks ask whether there is a value


def slim(table: pl.DataFrame) -> pl.DataFrame:
    """What the checks look at of a table of tracks."""
    known = [pl.col(name).is_not_null().replace(False, None) for name in KNOWN if name in table.columns]
    return table.select(*(name for name in SLIM if name in table.columns), *known)


@dataclass
class Tally:
    """Counts of rows, targets and parts, what was cleaned and why rows were rejected, and what the checks look at."""

    rows: int = 0
    counts: Counter[str] = field(default_factory=Counter)
    cleaning: Counter[str] = field(default_factory=Counter)
    status: Counter[str] = field(default_factory=Counter)
    refused: Counter[str] = field(default_factory=Counter)
    notes: dict[str, str] = field(default_factory=dict)
    seen: list[Seen] = field(default_factory=list)
    nis: NisCounts = field(default_factory=NisCounts)
    ends: list[Any] = field(default_factory=list)

    def add(self, table: pl.DataFrame) -> None:
        """Count one table of tracks."""
        self.counts["accepted"] += table.height
        self.status.update(dict(table["status"].cast(pl.String).value_counts().iter_rows()))
        self.nis.add(table)

    def close(self, tables: list[pl.DataFrame], parts: Sequence[tuple[int, int]], kind: str, known: Known) -> None:
        """Count the targets of a share; tables: its tracks, as `slim` leaves them, which are taken; parts: how many of
        2 and 3 axes, group by group; known: what holds for all shares.
        """
        whole = pl.concat(tables)
        tables.clear()
        self.seen.append(Seen.of(whole, kind, known.noise))
        self.counts["targets"] += whole["target"].n_unique()
        self.ends += [whole["time"].min(), whole["time"].max()]
        for axes, count in parts:
            self.counts["parts"] += count
            self.counts[f"axes {axes}"] += count

    def note(self, notes: Sequence[str]) -> None:
        """Notes of all shares; where several count the same, their sum."""
        for note in notes:
            kind = re.sub(r"\d[\d,.]*", "#", note)
            here, before = (re.match(r"(\d+)( .*)", text) for text in (note, self.notes.get(kind, "")))
            self.notes[kind] = f"{int(before[1]) + int(here[1])}{here[2]}" if here and before else note

    def refuse(self, rejected: pl.DataFrame) -> None:
        """Count rejected rows by reason."""
        self.refused.update(dict(reasons(rejected)))

    def merge(self, other: Tally) -> None:
        """Add what was counted elsewhere, of other targets."""
        self.rows += other.rows
        for name in ("counts", "cleaning", "status", "refused"):
            getattr(self, name).update(getattr(other, name))
        self.note(list(other.notes.values()))
        self.seen += other.seen
        self.ends += other.ends
        self.nis.rows += other.nis.rows
        self.nis.inside += other.nis.inside
        self.nis.total += other.nis.total

    def found(self, known: Known, settings: Settings) -> tuple[Sequence[Any], bool, dict[str, Any]]:
        """Findings, whether no track is plausible, and the lines of the summary that they are made from."""
        consistency = self.nis.shares()
        shared = self.cleaning["shared_times"] / max(self.rows, 1)
        found, hopeless = findings(Seen.together(self.seen), known.noise, settings.kind, consistency, shared)
        return found, hopeless, {"noise": known.noise, "consistency": consistency}

    def summary(self, files: Sequence[str], measured: Measurements | None, known: Known, settings: Settings) -> Any:
        """What was done and found; and whether no track is plausible. measured: some rows, which name the columns."""
        found, hopeless, lines = self.found(known, settings)
        notes = list(self.notes.values())
        flat, deep = self.counts["axes 2"], self.counts["axes 3"]
        if flat and measured is not None and measured.position != "polar":
            notes.append(in_the_plane(f"{flat}" if deep else "all", measured, settings.filter))
        notes += own_noise(settings, measured) if measured is not None else []
        notes += not_corrected((filter for _, filter in known.filters.values()), settings)
        return {
            "files": list(files),
            "rows": self.rows,
            "accepted": self.counts["accepted"],
            "rejected": dict(self.refused.most_common()),
            "targets": self.counts["targets"],
            "parts": self.counts["parts"],
            "start": plain(min(self.ends)),
            "end": plain(max(self.ends)),
            "columns": measured.named if measured else {},
            "unused_columns": measured.unused if measured else [],
            "notes": notes,
            "cleaning": dict(self.cleaning),
            "noise": lines["noise"],
            "filter": {f"{axes} axes": words_for(filter) for axes, (_, filter) in known.filters.items()},
            "status": dict(self.status.most_common()),
            "consistency": lines["consistency"],
            **settings.said(),
            "gap_seconds": known.pace.gap,
            "warnings": as_dicts(found, self.counts["targets"]),
        }, (found if hopeless and settings.check else None)

    def as_json(self) -> dict[str, Any]:
        """For `of_json`."""
        counters = {name: dict(getattr(self, name)) for name in ("counts", "cleaning", "status", "refused", "notes")}
        seen = [
            {
                "targets": _packed(each.targets),
                "shared": each.shared,
                "dates": _packed(each.dates),
                "steps": list(each.steps),
                "scored": each.scored,
            }
            for each in ([Seen.together(self.seen)] if self.seen else [])
        ]
        ends = [each.isoformat() if isinstance(each, datetime) else each for each in self.ends]
        nis = [self.nis.rows, self.nis.inside, self.nis.total]
        return {"rows": self.rows, **counters, "seen": seen, "nis": nis, "ends": ends}

    @classmethod
    def of_json(cls, body: dict[str, Any]) -> Tally:
        """As `as_json` wrote it."""
        seen = [
            Seen(
                _unpacked(each["targets"]),
                each["shared"],
                _unpacked(each["dates"]),
                tuple(each["steps"]),
                each["scored"],
            )
            for each in body["seen"]
        ]
        ends = [datetime.fromisoformat(each) if isinstance(each, str) else each for each in body["ends"]]
        counters = {name: Counter(body[name]) for name in ("counts", "cleaning", "status", "refused")}
        return cls(body["rows"], **counters, notes=body["notes"], seen=seen, nis=NisCounts(*body["nis"]), ends=ends)


def complete(frame: pl.DataFrame) -> pl.DataFrame:
    """Rejected rows with all columns of such."""
    return frame.select(
        (pl.col(name) if name in frame.columns else pl.lit(None)).cast(kind).alias(name)
        for name, kind in SCHEMA.items()
    )


def _packed(frame: pl.DataFrame) -> str:
    buffer = io.BytesIO()
    frame.write_ipc(buffer, compression="zstd")
    return base64.b64encode(buffer.getvalue()).decode("ascii")


def _unpacked(text: str) -> pl.DataFrame:
    return pl.read_ipc(io.BytesIO(base64.b64decode(text)))
