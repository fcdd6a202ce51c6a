"""Finished tracks smoothed with the marginals of their plots: those of a scan become one, as sure as they are together.

A track has taken plots z_j with weights w_j, W = Σ w_j, and β₀ = 1 − W of it is "no plot". One plot in their place has

    z = Σ w_j z_j / W,    R = (Σ w_j (R_j + (z_j − z)(z_j − z)ᵀ) / W + β₀ P⁻) / (1 − β₀)

P⁻ is the covariance of the predicted position. With one plot the gain becomes W K, as in probabilistic data association
(Bar-Shalom, Daum & Huang, IEEE Control Systems 29(6), 2009); smoothing goes on from there as ever (docs/smoothing.md).
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._engine import native
from ..checks import Array
from ..frozen import frozen

LEAST = 1e-3  # weight of all plots of a scan below which it is a miss
ANGLES = ("azimuth", "elevation", "bearing")


@frozen
class Taken:
    """The plots that tracks have taken: rows begin[k] to begin[k + 1] of row and weight belong to row k of the tracks.

    spread (N, axes, axes): covariance of the predicted position; NaN where a track has begun.
    """

    begin: NDArray[np.int64]
    row: NDArray[np.int64]
    weight: Array
    spread: Array

    @classmethod
    def of(cls, one: dict[str, Any], offered: NDArray[np.int64]) -> Taken:
        """Of one scan, as the engine says it; offered: which row each plot of the scan is."""
        return cls(one["begin"], offered[one["row"]], one["weight"], one["spread"])

    @classmethod
    def joined(cls, each: Sequence[Taken]) -> Taken:
        """Of scans one after the other; at least one."""
        begin = np.r_[0, np.cumsum(np.concatenate([np.diff(one.begin) for one in each]))].astype(np.int64)
        rows, weights, spreads = (
            np.concatenate([getattr(one, name) for one in each]) for name in ("row", "weight", "spread")
        )
        return cls(begin, rows.astype(np.int64), weights, spreads)

    def some(self, wanted: NDArray[np.int64]) -> Taken:
        """Of these rows of the tracks."""
        size = np.diff(self.begin)[wanted]
        begin = np.r_[0, np.cumsum(size)].astype(np.int64)
        at = np.repeat(self.begin[wanted] - begin[:-1], size) + np.arange(begin[-1])
        return Taken(begin, self.row[at], self.weight[at], self.spread[wanted])


def together(taken: Taken, z: Array, noise: Array, model: Any) -> tuple[Array, Array]:
    """One plot z (N, m) and its covariance R (N, m, m) in place of those taken; NaN and the noise where there is none.

    z (M, m) and noise (M, m, m) of all plots; model: what measures.
    """
    n, m = len(taken.begin) - 1, z.shape[1]
    owner = np.repeat(np.arange(n), np.diff(taken.begin))
    total = np.bincount(owner, weights=taken.weight, minlength=n)
    seen = total > LEAST
    # measured from the likeliest plot, so that angles do not wrap
    order = np.lexsort((-taken.weight, owner))
    likeliest = np.zeros(n, np.int64)
    likeliest[owner[order][::-1]] = taken.row[order][::-1]
    off = z[taken.row] - z[likeliest[owner]]
    for k, name in enumerate(model.components):
        if name in ANGLES:
            off[:, k] = np.angle(np.exp(1j * off[:, k]))
    w = taken.weight / np.maximum(total, 1e-300)[owner]
    mean = _summed(w[:, None] * off, owner, n)
    apart = np.nan_to_num(off - mean[owner])
    R = _summed(w[:, None, None] * (noise[taken.row] + apart[:, :, None] * apart[:, None, :]), owner, n)
    share = np.minimum(total, 1.0)[:, None, None]
    R = (R + (1.0 - share) * _measured(taken.spread, z[likeliest], model)) / np.maximum(share, LEAST)
    out = np.where(seen[:, None], z[likeliest] + mean, np.nan)
    return out, np.where(seen[:, None, None], R, np.eye(m) * np.diagonal(noise, axis1=1, axis2=2).mean(axis=0))


def _summed(values: Array, owner: NDArray[np.int64], n: int) -> Array:
    total = np.zeros((n, *values.shape[1:]))
    np.add.at(total, owner, values)
    return total


def _measured(spread: Array, z: Array, model: Any) -> Array:
    """Covariance of a position as that of a measurement near z; zero for what is no position, and where unknown."""
    n, m = z.shape
    axes = spread.shape[-1]
    out = np.zeros((n, m, m))
    known = np.isfinite(spread).all(axis=(1, 2)) & np.isfinite(z[:, :axes]).all(axis=1)
    if not known.any():
        return out
    at = z[known]
    slope = np.zeros((len(at), axes, axes))
    for k in range(axes):
        step = np.zeros(m)
        step[k] = 1e-6 if model.components[k] in ANGLES else 1e-2
        slope[:, :, k] = (model.positions(at + step) - model.positions(at - step))[:, :axes] / (2 * step[k])
    back = np.linalg.inv(slope)
    out[known, :axes, :axes] = back @ spread[known] @ np.swapaxes(back, 1, 2)
    return out


def smoothed(tracker: Any, scans: Any, found: Any, **lag: Any) -> Any:
    """What was found with every estimate smoothed, and existence too unless there is a lag.

    Errors: ValueError where the filter cannot be smoothed, or the plots taken were not kept.
    """
    if tracker.filter.not_smoothed:
        name = type(tracker.filter).__name__
        raise ValueError(f"smooth: {name} cannot be smoothed: {tracker.filter.not_smoothed}")
    if found.taken is None:
        raise ValueError("smooth: the plots of each track were not kept")
    if not len(found.id):
        return found
    z, R, sensor = _rows(tracker, scans, found)
    new, first = found.new, np.diff(found.id, prepend=-1) != 0
    offsets = np.r_[np.flatnonzero(new), len(new)]
    time = found.time - np.repeat(found.time[new], np.diff(offsets))
    smoother = _smoother(tracker)
    given = {"offsets": offsets, "sensor": sensor, "covariance": R}
    estimate = smoother.smooth(time, z, **given, outputs=("x", "P", "mode_probability"), **lag)
    known = np.isfinite(estimate.x).all(axis=1)
    results = dict(found.estimate.results)
    for name in ("x", "P", "mode_probability"):
        mask = known.reshape(-1, *(1,) * (results[name].ndim - 1))
        results[name] = np.where(mask, estimate.results[name], results[name])
    existence = found.existence if lag else _existence(found.existence, found.time, first, tracker.rules.life)
    return replace(found, existence=existence, estimate=replace(found.estimate, results=results))


def _rows(tracker: Any, scans: Any, found: Any) -> tuple[Array, Array, NDArray[np.int32]]:
    """Of each row of the tracks one plot, its covariance and its sensor."""
    columns = max(tracker._columns)
    z, R = np.full((len(found.id), columns), np.nan), np.tile(np.eye(columns), (len(found.id), 1, 1))
    which = np.array([tracker._index(None if scans.sensor is None else scans.sensor[k]) for k in range(len(scans))])
    sensor = which[found.scan].astype(np.int32)
    for k, model in enumerate(tracker._models):
        m = tracker._columns[k]
        rows = np.flatnonzero(sensor == k)
        if not len(rows):
            continue
        noise = np.tile(np.asarray(model.noise, float), (len(scans.z), 1, 1))
        if scans.covariance is not None:
            own = np.asarray(scans.covariance, float)
            noise = own if own.ndim == 3 else own[:, :, None] * np.eye(m)
        place, spread = together(found.taken.some(rows), scans.z[:, :m], noise, model)
        z[rows, :m] = place
        R[rows, :m, :m] = spread
    return z, R, sensor


def _smoother(tracker: Any) -> Any:
    """The filter as the tracker runs it: without gate, restart and coast, from one point."""
    smoother = copy.copy(tracker.filter)
    smoother.__dict__.pop("columns", None)
    smoother.declaration = tracker._declaration
    smoother.engine = native.Engine(smoother.declaration)
    smoother.sensors, smoother.initial = tuple(tracker._models), None
    return smoother


def _existence(r: Array, time: Array, new: NDArray[np.bool_], life: float) -> Array:
    """Probability that the target was there, given later scans too.

    It ends once and does not come back: r_k|N = r_k+1|N + (1 − r_k+1|N) r_k (1 − s) / (1 − s r_k), s = exp(−Δt/life).
    """
    out = r.copy()
    for k in range(len(r) - 2, -1, -1):
        if new[k + 1]:
            continue
        s = np.exp(-(time[k + 1] - time[k]) / life)
        out[k] = out[k + 1] + (1.0 - out[k + 1]) * r[k] * (1.0 - s) / max(1.0 - s * r[k], 1e-300)
    return out
