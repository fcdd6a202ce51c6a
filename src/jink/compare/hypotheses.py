"""Gaussian hypotheses about when a target last changed its behaviour: many per run, all runs at once.

Arrays carry run and hypothesis last, so that each operation is one pass over contiguous memory. The last
state component is the manoeuvre's parameter (acceleration, turn rate): zero with variance zero while quiet.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
NEVER = -1500.0  # log weight of what cannot be; finite, so that differences are


@dataclass
class Hypotheses:
    """Weighted Gaussians N(x, P) per run.

    log_weight, kind (0 quiet, else which level the manoeuvre was drawn from) and since (scan of the last
    change), each (runs, K); x (n, runs, K); P (n, n, runs, K).
    """

    log_weight: Array
    kind: NDArray[np.int8]
    since: NDArray[np.int32]
    x: Array
    P: Array

    def __len__(self) -> int:
        return self.log_weight.shape[1]

    @property
    def fields(self) -> tuple[NDArray, ...]:
        """All arrays, each with the hypotheses along its last axis."""
        return self.log_weight, self.kind, self.since, self.x, self.P


def join(parts: list[Hypotheses]) -> Hypotheses:
    """The hypotheses of all parts, side by side."""
    alike = zip(*(p.fields for p in parts), strict=True)
    return Hypotheses(*(np.concatenate(arrays, axis=-1) for arrays in alike))


def moments(weight: Array, x: Array, P: Array) -> tuple[Array, Array]:
    """Mean (n, runs) and covariance (n, n, runs) of a mixture with weights (runs, K).

    x̄ = Σ w x, P̄ = Σ w (P + (x − x̄)(x − x̄)ᵀ)
    """
    mean = np.einsum("irk,rk->ir", x, weight)
    d = x - mean[..., None]
    return mean, np.einsum("ijrk,rk->ijr", P, weight) + np.einsum("irk,jrk->ijr", d * weight, d)


def switch(
    h: Hypotheses, busy: bool, log_chance: float, levels: list[tuple[float, float]], scan: int
) -> list[Hypotheses]:
    """Newborn hypotheses: all that were not busy (or were, with busy = False) change now.

    Their pasts are merged into one Gaussian and the manoeuvre's parameter is drawn anew: levels has mean and
    sd of each Gaussian it is drawn from, equally likely; (0, 0) for becoming quiet.
    """
    log_weight = h.log_weight + np.where((h.kind > 0) == busy, NEVER, log_chance)
    highest = log_weight.max(axis=1, keepdims=True)
    weight = np.exp(log_weight - highest)
    total = weight.sum(axis=1, keepdims=True)
    mean, cov = moments(weight / total, h.x, h.P)
    mean, cov = mean[..., None], cov[..., None]
    cov[-1], cov[:, -1] = 0.0, 0.0
    share = highest + np.log(total) - np.log(len(levels))
    born = []
    for k, (level, sd) in enumerate(levels):
        x, P = mean.copy(), cov.copy()
        x[-1], P[-1, -1] = level, sd * sd
        kind = np.full_like(share, k + 1 if busy else 0, dtype=np.int8)
        born.append(Hypotheses(share, kind, np.full_like(share, scan, dtype=np.int32), x, P))
    return born


def update(h: Hypotheses, z: Array, variance: float, measured: tuple[int, ...]) -> Array:
    """Kalman update, one measured component after the other; returns log p(z | past) (runs,).

    S = P_mm + R, K = P_m / S, x += K ν, P −= K P_mᵀ, log w −= ½ (ν²/S + ln 2πS), then Σ w = 1.
    z (runs, m) m, NaN where missing (log p is 0 if all are); variance R (m²); measured: where each measured
    component stands in x.
    """
    for column, m in enumerate(measured):
        seen = np.isfinite(z[:, column])[:, None]
        nu = np.where(seen, z[:, column, None] - h.x[m], 0.0)
        S = h.P[m, m] + variance
        row = np.where(seen, h.P[m], 0.0)
        gain = row / S
        h.log_weight = h.log_weight - np.where(seen, 0.5 * (nu * nu / S + np.log(2 * np.pi * S)), 0.0)
        h.x += gain * nu
        h.P -= gain[:, None] * row[None]
    highest = h.log_weight.max(axis=1, keepdims=True)
    total = highest + np.log(np.exp(h.log_weight - highest).sum(axis=1, keepdims=True))
    h.log_weight = np.maximum(h.log_weight - total, NEVER)
    return total[:, 0]


def fuse_lightest(h: Hypotheses) -> Hypotheses:
    """One hypothesis less: each run's lightest is merged into that of its kind which changed nearest in time.

    The moments of the mixture stay as they are. Needs more hypotheses than kinds; the only one of a kind is
    left.
    """
    rows = np.arange(len(h.kind))
    alone = np.zeros(h.kind.shape, dtype=bool)
    for kind in range(int(h.kind.max()) + 1):
        same = h.kind == kind
        alone |= same & (same.sum(axis=1, keepdims=True) == 1)
    lightest = np.where(alone, np.inf, h.log_weight).argmin(axis=1)
    apart = np.abs(h.since - h.since[rows, lightest][:, None])
    apart = np.where(h.kind == h.kind[rows, lightest][:, None], apart, 1 << 30)
    apart[rows, lightest] = 1 << 30
    partner = apart.argmin(axis=1)
    log_total = np.logaddexp(h.log_weight[rows, lightest], h.log_weight[rows, partner])
    share = np.exp(h.log_weight[rows, lightest] - log_total)
    d = h.x[:, rows, lightest] - h.x[:, rows, partner]
    h.x[:, rows, partner] += share * d
    spread = h.P[:, :, rows, lightest] - h.P[:, :, rows, partner]
    h.P[:, :, rows, partner] += share * spread + share * (1 - share) * d[:, None] * d
    h.log_weight[rows, partner] = log_total
    for array in h.fields:
        array[..., rows, lightest] = array[..., -1]
    return Hypotheses(*(array[..., :-1] for array in h.fields))
