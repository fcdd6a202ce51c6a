"""Clocks of two sources that are hours apart: one tells UTC, the other the time of its zone.

Where two sources have one target, their paths are the same at the same times. If they are so only when one source's
times are moved by hours or half hours, its clock is off by these. Paths agree if they lie `SURE` times closer than they
would with times that are off by two minutes: targets at rest never do, and few that follow a timetable.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping

import numpy as np
import polars as pl

from ..io.evidence import EARTH_RADIUS
from ..io.measurements import DIMENSIONS
from .finding import NAMED, Finding

STEP = 1800.0  # s
MOST = 28  # steps: no zone is farther from UTC
TARGETS = 30  # that are looked at, those with most rows
SOURCES = 5  # of a target
ROWS = 300  # of a source
FEWEST = 10  # of them that must lie inside the other's path, and
SHARE = 0.3
WIDEST = 600.0  # s: a path is not known between positions farther apart
OFF = 120.0  # s
SURE = 20.0
MOVED = 50.0  # m at least that a target goes in this time


def hours_apart(rows: pl.DataFrame, position: str) -> list[Finding]:
    """A finding for each pair of sources whose clocks are apart. rows: measurements of whole targets."""
    source = rows["source"]
    if not rows.height or (source == source[0]).all():
        return []
    steps: dict[tuple[str, str], dict[str, int]] = defaultdict(dict)
    compared: Counter[str] = Counter()
    for target, paths in _seen_twice(rows, position):
        first, *others = sorted(paths, key=lambda name: -len(paths[name]))[:SOURCES]
        found = {other: _steps_apart(paths[first], paths[other]) for other in others}
        told = {other: many for other, many in found.items() if many is not None}
        # what follows a timetable is like that in some other hours, and in different ones
        if 2 * len(told) < len(found) or len(set(told.values()) - {0}) > 1:
            continue
        compared[target] = sum(len(path) for path in paths.values())
        for other, many in told.items():
            # by the names, not by which has more rows
            steps[min(first, other), max(first, other)][target] = many if first < other else -many
    return [finding for pair, found in steps.items() for finding in _said(*pair, found, compared)]


def _said(one: str, other: str, steps: dict[str, int], rows: Mapping[str, int]) -> Iterator[Finding]:
    """What is said of two sources, of whose targets these are so many steps apart."""
    many = max(set(steps.values()), key=list(steps.values()).count)
    names = [name for name, found in steps.items() if found == many]
    if not many or 2 * len(names) < len(steps):
        return
    hours = f"{abs(many) * STEP / 3600.0:g} h {'earlier' if many > 0 else 'later'}"
    yield Finding(
        "hours_apart",
        f"{other} has the same path as {one}, {hours}",
        names[:NAMED],
        len(names),
        sum(rows[name] for name in names),
        likely="a clock that tells the time of another zone, or summer time",
        mend="--time-zone names the zone of times that name none; otherwise correct the times of one source",
    )


def _seen_twice(rows: pl.DataFrame, position: str) -> Iterator[tuple[str, dict[str, np.ndarray]]]:
    """Targets that several sources have, and for each source times and places (n, 3): s, m, m."""
    names = [name for name in DIMENSIONS[position][:2] if name in rows.columns]
    known = rows.lazy().filter(pl.all_horizontal(pl.col("time", *names).is_finite()))
    counts = known.group_by("target", "source").len().filter(pl.col("len") >= FEWEST)
    several = counts.group_by("target").agg(pl.col("len").sum(), pl.len().alias("sources"))
    chosen = several.filter(pl.col("sources") > 1).sort("len", "target", descending=[True, False]).head(TARGETS)
    table = known.join(chosen.select("target"), on="target", how="semi").select("target", "source", "time", *names)
    for (target,), part in table.collect().sort("time").group_by(["target"], maintain_order=True):
        place = _plane(part[names[0]].to_numpy(), part[names[1]].to_numpy(), position)
        path = np.column_stack([part["time"].to_numpy(), np.real(place), np.imag(place)])
        sources = part["source"].to_numpy()
        paths = {name: path[sources == name] for name in part["source"].unique(maintain_order=True)}
        yield str(target), {name: each for name, each in paths.items() if len(each) >= FEWEST}


def _plane(first: np.ndarray, second: np.ndarray, position: str) -> np.ndarray:
    """Places (N,) on a plane in metres, as complex numbers."""
    if position == "polar":
        return first * np.exp(1j * second)
    if position == "cartesian":
        return first + 1j * second
    east = np.radians((second - second[0] + 180.0) % 360.0 - 180.0) * np.cos(np.radians(first))
    return EARTH_RADIUS * (east + 1j * np.radians(first))


def _steps_apart(one: np.ndarray, other: np.ndarray) -> int | None:
    """By how many steps the times of `other` must be moved to lie on the path of `one`; None where none, or several,
    would do.
    """
    some = other[np.unique(np.linspace(0, len(other) - 1, ROWS).astype(int))]
    widest = min(max(3.0 * float(np.median(np.diff(one[:, 0]))), 60.0), WIDEST)
    near = {k: _distance(one, some, k * STEP, widest) for k in range(-MOST, MOST + 1)}
    fitting = [
        k
        for k, far in near.items()
        if max(SURE * far, MOVED) <= min(_distance(one, some, k * STEP + off, widest) for off in (-OFF, OFF)) < np.inf
    ]
    if 0 in fitting:
        return 0
    return fitting[0] if len(fitting) == 1 and not SURE * near[fitting[0]] > near[0] else None


def _distance(one: np.ndarray, other: np.ndarray, moved: float, widest: float) -> float:
    """The median distance (m) of one path from the other with its times moved; infinite where too few meet."""
    time = other[:, 0] + moved
    after = np.searchsorted(one[:, 0], time)
    inside = (after > 0) & (after < len(one))
    after = np.clip(after, 1, len(one) - 1)
    inside &= one[after, 0] - one[after - 1, 0] <= widest
    if inside.sum() < max(FEWEST, SHARE * len(other)):
        return np.inf
    off = [np.interp(time[inside], one[:, 0], one[:, axis]) - other[inside, axis] for axis in (1, 2)]
    return float(np.median(np.hypot(*off)))
