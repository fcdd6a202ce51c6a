"""A table while it is being understood: its columns by role, which may change, and what was noticed on the way."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import polars as pl

from .columns import Column, Columns
from .conventions import Conventions
from .evidence import Motion
from .values import codes_of, numbers, texts

Problem = tuple[str, np.ndarray, pl.Series | None]  # reason, rows, the column whose values are to be shown

WILD = 1e100


@dataclass
class Sheet:
    """`frame` and its `roles`; `told` are the roles that the user named, which are believed."""

    where: str
    frame: pl.DataFrame
    position: str
    roles: dict[str, Column]
    others: dict[str, tuple[Column, ...]]
    told: frozenset[str]
    how: Conventions
    names: tuple[str, ...] = ()
    notes: list[str] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)
    own_units: set[str] = field(default_factory=set)  # roles whose fields told their units
    _codes: tuple[str, np.ndarray] | None = None  # of the column of that name

    @classmethod
    def of(cls, where: str, frame: pl.DataFrame, columns: Columns, how: Conventions) -> Sheet:
        """The table as its names say."""
        present = set(frame.columns)
        others = {
            role: tuple(column for column in found if column.name in present) for role, found in columns.others.items()
        }
        return cls(where, frame, columns.position, dict(columns.roles), others, columns.given, how, columns.names)

    def __contains__(self, role: str) -> bool:
        return role in self.roles

    def series(self, role: str) -> pl.Series:
        """The column of a role."""
        return self.frame[self.roles[role].name]

    def numbers(self, role: str) -> np.ndarray:
        """The column of a role as floats in its own unit; NaN for what no unit makes a measurement."""
        value = numbers(self.series(role))[0]
        return np.where(np.abs(value) < WILD, value, np.nan)

    def shown(self, role: str) -> str:
        """The name that people know a role's column by."""
        return self.roles[role].shown or self.roles[role].name

    def put(self, role: str, values: np.ndarray | pl.Series, unit: float | None, shown: str) -> None:
        """Give a role a new column made from others; `shown` names those."""
        name = f"\x00{role}"
        self.frame = self.frame.with_columns(pl.Series(name, values))
        self.roles[role] = Column(name, unit, shown)
        if role == "target":
            self._codes = None

    def drop(self, *roles: str) -> None:
        """Roles that turned out to mean nothing here."""
        for role in roles:
            self.roles.pop(role, None)

    def codes(self) -> np.ndarray:
        """A number per target, (N,); without a target column all rows are one."""
        if "target" not in self.roles:
            return np.zeros(self.frame.height, int)
        name = self.roles["target"].name
        if self._codes is None or self._codes[0] != name or len(self._codes[1]) != self.frame.height:
            self._codes = name, codes_of(texts(self.series("target")).fill_null("")).astype(np.int64)
        return self._codes[1]

    def motion(self, first: np.ndarray, second: np.ndarray, position: str | None = None) -> Motion:
        """Evidence from positions in SI units (geographic: degrees)."""
        reported = None
        if "speed" in self.roles:
            reported = self.numbers("speed") * (self.roles["speed"].unit or 1.0)
        return Motion(self.codes(), first, second, position or self.position, reported)
