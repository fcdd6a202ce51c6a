"""Whether the errors of positions are correlated in time, from the positions themselves.

Third differences of every row, of every second row, of every fourth ... cancel motion and leave noise (`scatter`).
Their variance at a spacing of s rows, T seconds each, is

    V(s) = w² + σ² (10 − 15 ρ + 6 ρ² − ρ³) / 10 + q s³ + j s⁶,   ρ = exp(−s T / τ)

of white errors w, errors σ that die away with τ (first-order Markov, as those of GPS), white accelerations and steady
turns. All parts are at least zero. Errors count as correlated where the variances are explained with σ, and not
without.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain, combinations

import numpy as np

from .._engine import native
from ..frozen import frozen
from .scatter import MEDIAN, grouped_quantile, third_differences

SPACINGS = (1, 2, 4, 8, 16, 32)
LEAST = 20  # differences of one spacing
ROWS = 8 * (LEAST + 2) + 1  # that have so many at a spacing of eight, as every target needs that is looked at
LASTING = (1.5, 2.5, 4.0, 6.0, 10.0, 15.0, 25.0)  # rows that errors may last
RELATIVE = 2.5  # sd of a variance that a median tells, in itself over the root of the number of differences
SURE = 25.0  # of squares in sds, that sigma has to save
GOOD = 12.0  # the same that may remain
AS_GOOD = 2.0  # more than the least that may remain, of another explanation
MORE = 3.0  # times the white variance
DOUBT = 3.0  # sds below what errors would make: then a target does not have them


@frozen
class Correlated:
    """Of each target: the sd (m) of its errors and the seconds over which they are correlated, NaN where they are not;
    the variances of its differences and their counts (G, K), and its usual step (s).
    """

    sd: np.ndarray
    seconds: np.ndarray
    variances: np.ndarray
    counts: np.ndarray
    step: np.ndarray

    def may_have(self, sd: float, seconds: float) -> np.ndarray:
        """Targets (G,) whose differences are not clearly smaller than errors of this sd and duration make them."""
        made = sd**2 * shape_of(np.array(SPACINGS) * self.step[:, None] / seconds)
        sure = 1.0 - DOUBT * RELATIVE / np.sqrt(np.maximum(self.counts, 1))
        with np.errstate(invalid="ignore"):
            smaller = self.variances < np.maximum(sure, 0.0) * made
        return np.logical_not(np.asarray(smaller).any(axis=1))


def shape_of(rows: np.ndarray) -> np.ndarray:
    """The variance of third differences of first-order Markov errors of sd 1, in that of white ones; rows: s T / τ."""
    rho = np.exp(-rows)
    return (10.0 - 15.0 * rho + 6.0 * rho**2 - rho**3) / 10.0


def correlated_errors(time: np.ndarray, plane: np.ndarray, target: np.ndarray, targets: int) -> Correlated:
    """Of each target whether its errors are correlated.

    time (N,) s, plane (N, 2) m, target (N,) numbers the targets, whose rows stand together.
    """
    new = np.diff(target, prepend=-1) != 0
    starts = np.flatnonzero(new)
    lengths = np.diff(np.r_[starts, time.size])
    V, n = np.full((targets, len(SPACINGS)), np.nan), np.zeros((targets, len(SPACINGS)), int)
    # most targets are told from others by two spacings, so that the rest is looked at of few
    long = np.zeros(targets, bool)
    long[target[starts[lengths >= ROWS]]] = True
    looked = long[target]
    sd, seconds = np.full(targets, np.nan), np.full(targets, np.nan)
    growing = np.zeros(targets, bool)
    for these in ((2, 0), (1, 3), (4, 5)):
        if not looked.any():
            break
        rows = slice(None) if looked.all() else looked
        some = time[rows], plane[rows], new[rows], target[rows]
        for k in these:
            usual = native.usual_step(time, new, SPACINGS[k])
            V[:, k], n[:, k] = _variances(*some, targets, usual, SPACINGS[k])
        with np.errstate(invalid="ignore"):
            growing = (V[:, 2] > 1.5 * V[:, 0]) & (V[:, 0] > 0)
            if these[0] == 1:
                growing &= np.isfinite(V[:, :4]).all(axis=1)
        looked &= growing[target]
    grows = np.flatnonzero(growing & np.isfinite(V[:, :4]).all(axis=1))
    if not grows.size:
        return Correlated(sd, seconds, V, n, np.full(targets, np.nan))
    step = grouped_quantile(np.diff(time, prepend=np.nan), target, targets, 0.5)
    found, rows = _explained(V[grows], n[grows])
    sd[grows], seconds[grows] = found, rows * step[grows]
    return Correlated(sd, seconds, V, n, step)


def _variances(
    time: np.ndarray, plane: np.ndarray, new: np.ndarray, target: np.ndarray, targets: int, usual: float, spacing: int
) -> tuple[np.ndarray, np.ndarray]:
    """At one spacing, the variance of third differences of each target (T,), NaN of too few; and how many there are."""
    difference, index = third_differences(time, plane, new, usual, spacing)
    row = target[index]
    sd = MEDIAN * grouped_quantile(np.abs(difference, out=difference), row, targets, 0.5, least=2 * LEAST)
    return sd**2, np.bincount(row, minlength=targets)


def _explained(V: np.ndarray, n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """σ and the rows that errors last (G,), NaN where they are not correlated; V, n (G, K): variances and counts."""
    known = np.isfinite(V)
    weight = np.where(known, np.sqrt(np.maximum(n, 1)) / (RELATIVE * np.where(known, V, 1.0)), 0.0)
    target = weight * np.where(known, V, 0.0)
    s = np.array(SPACINGS, float)
    plain = np.stack([np.ones_like(s), s**3, s**6])
    least = np.full(len(V), np.inf)
    for parts in _subsets(3):
        _, squares = _fit(plain[list(parts)], weight, target)
        least = np.minimum(least, squares)
    sigma, rows = np.full(len(V), np.nan), np.full(len(V), np.nan)
    # where motion and white errors explain nearly all, nothing is left to save
    some = np.flatnonzero(least > SURE)
    if some.size:
        sigma[some], rows[some] = _markov(plain, weight[some], target[some], least[some])
    return sigma, rows


def _markov(
    plain: np.ndarray, weight: np.ndarray, target: np.ndarray, least: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The same with errors that die away; least (G,): the squares without them."""
    groups, s, fits = len(target), np.array(SPACINGS, float), []
    for lasting in LASTING:
        markov = shape_of(s / lasting)
        for parts in _subsets(3):
            values, squares = _fit(np.vstack([markov, plain[list(parts)]]), weight, target)
            white = values[:, 1] if 0 in parts else np.zeros(groups)
            fits.append((squares, values[:, 0], white, np.full(groups, lasting)))
    squares, sigma, white, rows = (np.array(each) for each in zip(*fits, strict=True))
    best = squares.min(axis=0)
    # of those that fit about as well the largest errors: too small an sd is the worse mistake
    chosen = np.where(squares <= best + AS_GOOD, sigma, -np.inf).argmax(axis=0)
    sigma, white, rows = (each[chosen, np.arange(groups)] for each in (sigma, white, rows))
    sure = (least - best > SURE) & (best < GOOD) & (sigma > MORE * white)
    return np.where(sure, np.sqrt(np.maximum(sigma, 0.0)), np.nan), np.where(sure, rows, np.nan)


def _subsets(count: int) -> Iterator[tuple[int, ...]]:
    return chain.from_iterable(combinations(range(count), k) for k in range(count + 1))


def _fit(parts: np.ndarray, weight: np.ndarray, target: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least squares of each group by `parts` (P, K): values (G, P) and squares (G,), infinite where a value is below
    zero.
    """
    if not len(parts):
        return np.zeros((len(target), 0)), (target**2).sum(axis=1)
    # of one size, so that no power of the spacing decides what is singular
    scale = parts.max(axis=1)
    A = weight[:, :, None] * (parts / scale[:, None]).T
    normal = np.einsum("gkp,gkq->gpq", A, A)
    normal += 1e-12 * np.einsum("gpp->g", normal)[:, None, None] * np.eye(len(parts))
    values = np.linalg.solve(normal, np.einsum("gkp,gk->gp", A, target)[..., None])[..., 0]
    squares = ((np.einsum("gkp,gp->gk", A, values) - target) ** 2).sum(axis=1)
    return values / scale, np.where((values >= 0).all(axis=1), squares, np.inf)
