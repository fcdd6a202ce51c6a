"""How well a filter predicts positions that it has not seen: the mean log density of each, given those before it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..catalogue.choose import EARTH_RADIUS
from ..io.geodesy import SiteFrame
from ..models.observed import to_positions
from .placing import Placed

# makes a filter of measured components and their typical sds
Choose = Callable[[tuple[str, ...], Mapping[str, float]], Any]
WORTH = 2e-3  # what positions have to gain in a row for a rate to be used
SETTLED = 5  # rows of a part before its predictions count
OUTLIER, SPREAD = 0.01, 1e4  # share of positions that are wrong, and how far they lie (m): one alone decides nothing
BLOCK = 50  # rows that count as one when the standard error of a few parts is told: neighbours are alike
FEW = 5  # parts, or blocks, below which rows count by themselves
PIECES = 40  # parts that a sample is taken from
STEP = 1e-6


def position_scores(
    filter: Any, placed: Placed, covariance: np.ndarray, places: tuple[np.ndarray, np.ndarray]
) -> np.ndarray:
    """Log densities (N, 2) of each row's horizontal position and height before it is seen; NaN where nothing is
    predicted or measured.

    Every row is given twice, first without its measurement: that estimate is the prediction. places: positions (N,
    axes) in metres and their covariance, which are scored. covariance: of `placed.z`, row by row.
    """
    z = np.repeat(placed.z, 2, axis=0)
    z[::2] = np.nan
    found = filter.filter(
        np.repeat(placed.time, 2),
        z,
        offsets=2 * placed.offsets,
        covariance=np.repeat(covariance, 2, axis=0),
        outputs=("x", "P"),
    )
    x, P = found.x[::2], found.P[::2]
    index = [found.components.index(f"p{axis}") for axis in "xyz"[: placed.axes]]
    position, noise = places
    scores = np.full((len(position), 2), np.nan)
    for column, axes in enumerate(((0, 1), (2,))[: placed.axes - 1]):
        which = [index[axis] for axis in axes]
        error = position[:, axes] - x[:, which]
        spread = P[:, which][:, :, which] + noise[:, axes][:, :, axes]
        scores[:, column] = _log_density(error, spread)
    since = np.arange(len(x)) - np.repeat(placed.offsets[:-1], np.diff(placed.offsets))
    scores[since < SETTLED] = np.nan
    return scores


def _log_density(error: np.ndarray, spread: np.ndarray) -> np.ndarray:
    """Of a Gaussian, with some outliers spread evenly."""
    out = np.full(len(error), np.nan)
    good = np.isfinite(error).all(axis=1) & np.isfinite(spread).all(axis=(1, 2))
    error, spread = error[good], spread[good]
    m = error.shape[1]
    determinant = np.linalg.det(spread) if m > 1 else spread[:, 0, 0]
    sound = determinant > 0
    spread = np.where(sound[:, None, None], spread, np.eye(m))
    square = (error * np.linalg.solve(spread, error[..., None])[..., 0]).sum(axis=1)
    log = -0.5 * (square + np.log(np.where(sound, determinant, 1.0)) + m * np.log(2.0 * np.pi))
    log = np.where(sound, log, -np.inf)
    out[good] = np.logaddexp(np.log1p(-OUTLIER) + log, np.log(OUTLIER) - m * np.log(SPREAD))
    return out


def gain(before: np.ndarray, after: np.ndarray, part: np.ndarray) -> tuple[float, float]:
    """What `after` has more than `before` in a row, and its standard error over parts, or blocks of few parts.

    part (N,): number of each row's part.
    """
    difference = after - before
    known = np.isfinite(difference)
    difference, part = difference[known], part[known]
    if not difference.size:
        return 0.0, np.inf
    unit = part if np.unique(part).size >= FEW else np.arange(difference.size) // BLOCK
    _, unit, count = np.unique(unit, return_inverse=True, return_counts=True)
    if count.size < FEW:
        return float(difference.mean()), float(difference.std() / np.sqrt(difference.size))
    mean = float(difference.mean())
    excess = np.bincount(unit, weights=difference - mean)
    return mean, float(np.sqrt((excess**2).sum()) / difference.size)


def measured_places(placed: Placed, covariance: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Measured positions (N, axes) in metres and their covariances; those of a radar to the first order."""
    axes = placed.axes
    if placed.components[0] != "range":
        return placed.z[:, :axes], covariance[:, :axes, :axes]
    names = tuple({"altitude": "height"}.get(name, name) for name in placed.components[:axes])
    z = placed.z[:, :axes]
    radius = placed.frame.earth_radius if isinstance(placed.frame, SiteFrame) else EARTH_RADIUS
    seen = (names, (0.0, 0.0, 0.0), "north", radius)
    position = to_positions(z, *seen)
    jacobian = np.empty((len(z), axes, axes))
    for column in range(axes):
        step = STEP * (np.nan_to_num(np.abs(z[:, column])) + 1.0)
        moved = z.copy()
        moved[:, column] += step
        jacobian[:, :, column] = (to_positions(moved, *seen) - position) / step[:, None]
    variance = covariance[:, :axes]
    return position, np.einsum("nij,nj,nkj->nik", jacobian, variance, jacobian)


@dataclass
class Used:
    """What was found of rates: the sds of those that are used (m/s), and sentences for the summary.

    fresh_only: those whose repeated reports are left out; stated: what the source usually states as their sds; usual:
    how far reported velocities usually are from the motion that positions show (m/s), None until it is known.
    """

    sd: dict[str, float] = field(default_factory=dict)
    origin: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    gains: dict[str, float] = field(default_factory=dict)
    fresh_only: frozenset[str] = frozenset()
    stated: dict[str, float] = field(default_factory=dict)
    usual: float | None = None

    def figures(self) -> dict[str, Any]:
        """For the lines of the summary on noise."""
        sources: dict[str, Any] = {f"{name}_sd_from": self.origin[name] for name in self.sd}
        return {f"{name}_sd": float(sd) for name, sd in self.sd.items()} | sources


def sample_of(placed: Placed, most: int) -> tuple[Placed, np.ndarray]:
    """Pieces of parts from all over the table, some `most` rows; and which rows they are.

    From each part come as many rows in a row: its first ones, those in its middle or its last ones, in turn.
    """
    offsets = placed.offsets
    if offsets[-1] <= most:
        return placed, np.arange(offsets[-1])
    count = min(offsets.size - 1, PIECES)
    parts = np.unique(np.linspace(0, offsets.size - 2, count).round().astype(int))
    length = most // parts.size
    pieces = []
    for number, part in enumerate(parts):
        spare = max(int(offsets[part + 1] - offsets[part]) - length, 0)
        begin = int(offsets[part]) + spare * (number % 3) // 2
        pieces.append(np.arange(begin, min(begin + length, int(offsets[part + 1]))))
    rows = np.concatenate(pieces)
    some = placed.some(rows)
    some.new[np.cumsum([0, *map(len, pieces[:-1])])] = True
    return some, rows
