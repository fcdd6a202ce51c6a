"""How far a set of estimates is from a set of targets: GOSPA, OSPA and OSPA⁽²⁾.

Points are (n, axes). Points nearer than the cut-off c can be a pair, and pairs are chosen at the least total cost.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._engine import native
from ..checks import Array, by_hints, positive

Index = NDArray[np.int64]


class Pairs(NamedTuple):
    """Which target belongs to which estimate, and how far apart they are; all (k,)."""

    truth: Index
    estimate: Index
    distance: Array


class Gospa(NamedTuple):
    """The metric and its parts to the power of p: value^p = localisation + missed + false (for alpha = 2)."""

    value: float
    localisation: float
    missed: float
    false: float
    pairs: Pairs


def pairs_within(truth: ArrayLike, estimate: ArrayLike, c: float, p: float = 2.0) -> Pairs:
    """The pairs nearer than c that make Σ (dᵖ − cᵖ) least: the optimal sub-pattern assignment."""
    x, y = _points("truth", truth), _points("estimate", estimate)
    if not len(x) or not len(y):
        return Pairs(np.zeros(0, int), np.zeros(0, int), np.zeros(0))
    if x.shape[1] != y.shape[1]:
        raise ValueError(f"estimate: expected {x.shape[1]} axes as the truth has, got {y.shape[1]}")
    row, column, distance = _near(x, y, c)
    begin = np.searchsorted(row, np.arange(len(x) + 1)).astype(np.int64)
    found = np.asarray(native.assign(begin, column, distance**p - c**p, len(y)))
    chosen = np.flatnonzero(found >= 0)
    return Pairs(chosen, found[chosen], np.sqrt(((x[chosen] - y[found[chosen]]) ** 2).sum(axis=1)))


@by_hints
def gospa(truth: ArrayLike, estimate: ArrayLike, c: float, p: float = 2.0, alpha: float = 2.0) -> Gospa:
    """Generalised optimal sub-pattern assignment metric, in the unit of the points.

    d = (min over assignments γ of Σ_{(i,j) ∈ γ} d(xᵢ, yⱼ)ᵖ + cᵖ/2 (|X| + |Y| − 2|γ|))^(1/p) for α = 2: errors of
    localisation, missed targets and false ones, each of the last two at cᵖ/2. For another α the sets are paired as far
    as they go with min(d, c), and what is left over costs cᵖ/α; ``missed`` and ``false`` are counted the same way.
    Errors: ValueError for c, p or α outside (0, ∞), [1, ∞), (0, 2].
    Source: Rahmathullah, García-Fernández & Svensson, "Generalized optimal sub-pattern assignment metric", Fusion 2017.
    """
    _check(c, p)
    if not 0 < alpha <= 2:
        raise ValueError(f"alpha: expected a number above 0 and at most 2, got {alpha!r}")
    x, y = _points("truth", truth), _points("estimate", estimate)
    pairs = pairs_within(x, y, c, p)
    near, localisation = len(pairs.truth), float((pairs.distance**p).sum())
    missed, false = c**p / 2 * (len(x) - near), c**p / 2 * (len(y) - near)
    beyond = (c**p / alpha - c**p / 2) * abs(len(x) - len(y))
    return Gospa((localisation + missed + false + beyond) ** (1 / p), localisation, missed, false, pairs)


@by_hints
def ospa(truth: ArrayLike, estimate: ArrayLike, c: float, p: float = 2.0) -> float:
    """Optimal sub-pattern assignment metric, in the unit of the points; 0 for two empty sets.

    d = (1/n (min over permutations of Σ min(d, c)ᵖ + cᵖ |n − m|))^(1/p), n the larger and m the smaller size.
    Source: Schuhmacher, Vo & Vo, IEEE Trans. SP 56(8), 2008.
    """
    _check(c, p)
    x, y = _points("truth", truth), _points("estimate", estimate)
    most = max(len(x), len(y))
    if not most:
        return 0.0
    pairs = pairs_within(x, y, c, p)
    return float((((pairs.distance**p).sum() + c**p * (most - len(pairs.truth))) / most) ** (1 / p))


@by_hints
def ospa2(truth: Sequence[ArrayLike], estimate: Sequence[ArrayLike], c: float, p: float = 2.0, q: float = 1.0) -> float:
    """OSPA between two sets of tracks over a window, so that a change of identity costs.

    Tracks are (scans, axes), NaN where they are not there. The distance of two tracks is (mean of d_k^q)^(1/q) over the
    scans in which either is there; d_k = min(d, c) with both there, and c with one. Of those distances OSPA is taken.
    Source: Beard, Vo & Vo, "OSPA(2): using the OSPA metric to evaluate multi-target tracking performance", ICCAIS 2017.
    """
    _check(c, p)
    n, m = len(truth), len(estimate)
    if not max(n, m):
        return 0.0
    base = np.array([[_track_distance(np.asarray(a), np.asarray(b), c, q) for b in estimate] for a in truth])
    cost = base.reshape(n, m) ** p - c**p
    begin, column = np.arange(n + 1, dtype=np.int64) * m, np.tile(np.arange(m, dtype=np.int64), n)
    found = np.asarray(native.assign(begin, column, np.ascontiguousarray(cost.reshape(-1)), m), int)
    gain = sum(cost[i, j] for i, j in enumerate(found) if j >= 0)
    return float(((c**p * max(n, m) + gain) / max(n, m)) ** (1 / p))


def _track_distance(a: Array, b: Array, c: float, q: float) -> float:
    here, there = np.isfinite(a).all(axis=1), np.isfinite(b).all(axis=1)
    either = here | there
    if not either.any():
        return 0.0
    d = np.full(len(a), c)
    both = here & there
    d[both] = np.minimum(np.sqrt(((a[both] - b[both]) ** 2).sum(axis=1)), c)
    return float((d[either] ** q).mean() ** (1 / q))


def _near(x: Array, y: Array, c: float) -> tuple[Index, Index, Array]:
    """Row, column and distance of all pairs nearer than c, row after row."""
    order = np.argsort(y[:, 0], kind="stable")
    along = y[order, 0]
    first, last = np.searchsorted(along, x[:, 0] - c), np.searchsorted(along, x[:, 0] + c, side="right")
    count = last - first
    row = np.repeat(np.arange(len(x)), count)
    at = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count) + np.repeat(first, count)
    column = order[at]
    distance = np.sqrt(((x[row] - y[column]) ** 2).sum(axis=1))
    near = distance < c
    row, column, distance = row[near], column[near], distance[near]
    sorted_ = np.lexsort((column, row))
    return row[sorted_], np.ascontiguousarray(column[sorted_], np.int64), np.ascontiguousarray(distance[sorted_])


def _points(name: str, points: ArrayLike) -> Array:
    p = np.asarray(points, dtype=float)
    if p.size == 0:
        return np.zeros((0, p.shape[1] if p.ndim == 2 else 2))
    if p.ndim != 2 or not np.isfinite(p).all():
        raise ValueError(f"{name}: expected finite points (n, axes), got shape {p.shape}")
    return p


def _check(c: float, p: float) -> None:
    positive("c", c)
    if not (1 <= p < math.inf):
        raise ValueError(f"p: expected a number from 1, got {p!r}")
