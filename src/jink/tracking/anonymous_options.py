"""What is asked of plots without identity, and whether a table holds such."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import polars as pl

from ..checks import unknown
from ..frozen import frozen
from ..io.errors import InputError
from ..io.measurements import DIMENSIONS, Measurements

SHARED = 0.3  # of the times: if so many are shared by several rows, a table without identity holds several targets
APART = 0.05  # of what the table spans: rows of one time nearer to each other may be one target and a coarse clock


@frozen
class Anonymous:
    """What `track` is told of plots without identity; None is estimated.

    detection probability; clutter: false plots per scan; new_per_hour; drop_after (s); period (s) of a scan, where
    every plot has its own time; sectors of a turn of the antenna, 1: turns are taken whole; association: its name.
    """

    detection: float | None = None
    clutter: float | None = None
    new_per_hour: float | None = None
    drop_after: float | None = None
    period: float | None = None
    sectors: int | None = None
    association: str = "marginal"

    @classmethod
    def of(cls, given: bool | Mapping[str, Any]) -> Anonymous | None:
        """From what `jink.track` was given. Errors: InputError."""
        if isinstance(given, bool):
            return cls() if given else None
        names = cls.__dataclass_fields__
        if not isinstance(given, Mapping):
            raise InputError(f"anonymous: expected True, False or options by name, got {given!r:.60}")
        for name in given:
            if name not in names:
                raise InputError(f"anonymous: {unknown('option', str(name), names)}")
        return cls(**given)

    def __post_init__(self) -> None:
        from ..association.rules import ASSOCIATIONS

        if self.association not in ASSOCIATIONS:
            raise InputError(f"association: {unknown('association', self.association, ASSOCIATIONS)}")
        if self.detection is not None and not 0 < self.detection < 1:
            raise InputError(f"detection is {self.detection!r}; expected a probability between 0 and 1")
        for name in ("clutter", "new_per_hour"):
            value = getattr(self, name)
            if value is not None and not 0 <= value < np.inf:
                raise InputError(f"{name.replace('_', '-')} is {value!r}; expected a number from 0")
        for name in ("period", "drop_after"):
            value = getattr(self, name)
            if value is not None and not 0 < value < np.inf:
                raise InputError(f"{name.replace('_', '-')} is {value!r}; expected seconds above 0")
        if self.sectors is not None and not (self.sectors == 1 or 3 <= self.sectors <= 3600):
            raise InputError(f"sectors is {self.sectors!r}; expected 3 to 3600 of a turn, or 1 for whole turns")


def is_anonymous(measurements: Measurements) -> bool:
    """Has the table no identity, and several rows of one time far apart, which one target cannot have?"""
    rows = measurements.rows
    if "target" in measurements.named or rows.height < 2:
        return False
    places = [pl.col(name).fill_nan(None) for name in DIMENSIONS[measurements.position][:2] if name in rows.columns]
    spans = [(place.max() - place.min()).alias(f"span {k}") for k, place in enumerate(places)]
    each = rows.group_by("time").agg(pl.len().alias("n"), *spans)
    if not (each["n"].to_numpy() > 1).mean() > SHARED:
        return False
    whole = rows.select(*spans)
    apart = each.filter(pl.col("n") > 1)
    shares = [apart[s.name].median() / s[0] for s in whole if s[0]]  # pyright: ignore[reportOperatorIssue]
    return bool(shares) and all(share is not None and share > APART for share in shares)
