"""Positions that a radar has seen: their noise is that of its range and azimuth.

So are x and y of a radar at the origin, whose table has range and azimuth too. Where a site is named, x and y or places
on the map may be seen from there: their scatter decides.
The error of a range lies along the line of sight, that of an azimuth across it and grows with the range:
R = u uᵀ sd_r² + v vᵀ (r sd_a)²,  u along, v across.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import polars as pl

from ..filters.row_noise import RowNoise
from ..io.geodesy import DevelopedFrame, SiteFrame, lines_of_sight
from .placing import Placed
from .scatter import MEDIAN, component_sd, third_differences

MARK = "seen_by_radar"  # column of the rows
# columns of rows that may be seen from a site: range (m), azimuth there, and direction of the line of sight here
SIGHT = ("sight_range", "sight_azimuth", "sight_direction")
LESS = 0.01  # nats that a radar's noise must be likelier by, to be believed where its site is named


def with_lines_of_sight(placed: Placed, site: SiteFrame) -> Placed:
    """The rows with their lines of sight from a site; those of another kind of position as they are."""
    if placed.components[:2] != ("x", "y"):
        return placed
    frame = placed.frame
    if isinstance(frame, DevelopedFrame):
        rows = placed.rows
        reach, azimuth, there = lines_of_sight(site, rows["latitude"].to_numpy(), rows["longitude"].to_numpy())
        direction = there - frame.anchor_convergence
    else:
        reach, azimuth = np.hypot(*placed.plane.T), np.arctan2(*placed.plane.T)
        direction = azimuth
    sight = dict(zip(SIGHT, (reach, azimuth, direction), strict=True))
    return replace(placed, rows=placed.rows.with_columns(**{name: pl.Series(each) for name, each in sight.items()}))


def covariances(
    placed: Placed,
    measured: np.ndarray,
    starts: np.ndarray,
    group: np.ndarray,
    groups: int,
    given: Mapping[str, float],
    other: RowNoise,
    decided: Mapping[str, float] | None = None,
) -> tuple[RowNoise, np.ndarray, np.ndarray] | None:
    """The noise of positions, and sds of range (m) and azimuth (rad) of each group; None where the rows are no
    radar's, or the data tell too little.

    measured (N,): rows with a position; starts: first rows of parts among them; group (N,) numbers the sources; other:
    the noise without a radar; decided: figures of other rows of the table, which say whose noise it is.
    """
    columns = placed.rows.columns
    stated = "cov_ee" in columns or ("position_sd" in columns and bool(placed.rows["position_sd"].is_finite().any()))
    certain, perhaps = MARK in columns, SIGHT[0] in columns and not stated
    if not (certain or perhaps) or "position" in given or placed.components[:2] != ("x", "y"):
        return None
    of = groups
    if certain:
        reach, azimuth = np.hypot(*placed.plane.T), np.arctan2(*placed.plane.T)
        direction = azimuth
    else:
        reach, azimuth, direction = (placed.rows[name].to_numpy() for name in SIGHT)
        # one radar, whoever is seen
        group, groups = np.zeros_like(group), 1
    time = placed.time[measured]
    # angles of neighbouring rows go on across the turn
    along = component_sd(time, reach[measured], starts, group[measured], groups)
    across = component_sd(time, np.unwrap(azimuth[measured]), starts, group[measured], groups)
    along = np.full(groups, given["range"]) if "range" in given else along
    across = np.full(groups, given["azimuth"]) if "azimuth" in given else across
    if not certain and decided is not None:
        if "range_sd" not in decided:
            return None
        along, across = np.array([decided["range_sd"]]), np.array([decided["azimuth_sd"]])
    if not (np.isfinite(along) & np.isfinite(across) & (along > 0) & (across > 0)).all():
        return None
    sin, cos = np.sin(direction), np.cos(direction)
    # at the radar itself no direction is left: a plot within the error of its range counts as that far away
    length, width = along[group] ** 2, (np.maximum(reach, along[group]) * across[group]) ** 2
    xx, yy = sin * sin * length + cos * cos * width, cos * cos * length + sin * sin * width
    R = RowNoise(2, {(0, 0): xx, (0, 1): sin * cos * length - cos * sin * width, (1, 1): yy})
    if certain:
        return R, along, across
    if decided is not None:
        return R, np.broadcast_to(along, of), np.broadcast_to(across, of)
    values = np.column_stack([reach[measured], np.unwrap(azimuth[measured]), placed.plane[measured]])
    if not _likelier(time, values, starts, along, across, other.some(measured)):
        return None
    return R, np.broadcast_to(along, of), np.broadcast_to(across, of)


def _likelier(
    time: np.ndarray, values: np.ndarray, starts: np.ndarray, along: np.ndarray, across: np.ndarray, other: RowNoise
) -> bool:
    """Whether the scatter of values (N, 4), range, azimuth, x and y, is rather a radar's than the same in all
    directions, or than the other noise.
    """
    d, index = third_differences(time, values, starts)
    reach, even = np.maximum(values[index, 0], along), float(MEDIAN * np.median(np.abs(d[:, 2:])))
    if not even > 0:
        return False
    radar = _loss(d[:, 0], along) + _loss(reach * d[:, 1], reach * across)
    root = np.linalg.cholesky(other[index])
    white = np.linalg.solve(root, d[:, 2:, None])[..., 0]
    apart = np.log(np.linalg.det(root)) + _loss(white[:, 0], 1.0) + _loss(white[:, 1], 1.0)
    gains = (_loss(d[:, 2], even) + _loss(d[:, 3], even) - radar, apart - radar)
    return all(float(gain.mean()) > LESS for gain in gains)


def _loss(d: np.ndarray, sd: np.ndarray | float) -> np.ndarray:
    """Minus the log density of Student's t with 4 degrees of freedom, which outliers do not rule, up to a constant."""
    return np.log(sd) + 2.5 * np.log1p((d / sd) ** 2 / 4.0)
