"""Smoothing for the stepwise filters: core/run/smooth_one.hpp and core/run/smooth.hpp, over many tracks at once.

One mode: Rauch, Tung & Striebel, AIAA Journal 3(8), 1965. Several: messages from the future; of each mode j
the measurements after a scan say

    log p(Z | x, j) = s + hᵀ(x − xⱼ) − ½ (x − xⱼ)ᵀ J (x − xⱼ),   xⱼ the filtered estimate.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .._engine import native
from .functions import Array, at_scan
from .scan import Scan
from .states import Record, Rows

EPS = float(np.finfo(float).eps)
LEAST = 1e-300  # of a weight: no pair of modes dies for good
Smoothed = tuple[int, list[Array], list[Array], Array]


@dataclass
class Messages(Rows):
    """Of each mode: J (B, n, n), h (B, n), s (B,)."""

    J: list[Array]
    h: list[Array]
    s: list[Array]


@dataclass
class Pair:
    """Mode i before, mode j after: its message, the smoothed estimate and weight of mode i given it."""

    J: Array
    h: Array
    x: Array
    P: Array
    log_weight: Array


def backward(engine: Scan, records: list[Record]) -> Iterator[Smoothed]:
    """(k, x, P, mode probability) from the last scan to the first; without a follower as it was filtered."""
    messages: Messages | None = None
    after: tuple[Record, list[Array], list[Array]] | None = None
    for k in reversed(range(len(records))):
        now = records[k]
        x, P, probability = [a.copy() for a in now.x], [a.copy() for a in now.P], now.probability.copy()
        empty = _empty(now)
        if after is not None:
            later, xs, Ps = after
            rows = np.flatnonzero(later.linked)
            with at_scan(k + 1), np.errstate(all="ignore"):
                if len(rows) and len(x) == 1:
                    x[0][rows], P[0][rows] = _one(engine, now.take(rows), later.take(rows), xs[0][rows], Ps[0][rows])
                elif len(rows) and messages is not None:
                    step = Several(engine, now.take(rows), later.take(rows), messages.take(rows))
                    for i in range(len(x)):
                        x[i][rows], P[i][rows] = step.x[i], step.P[i]
                    probability[rows] = step.probability
                    empty.put(rows, step.messages)
        messages, after = empty, (now, x, P)
        yield k, x, P, probability


def _empty(now: Record) -> Messages:
    return Messages(
        [np.zeros_like(P) for P in now.P],
        [np.zeros_like(x) for x in now.x],
        [np.zeros(len(x)) for x in now.x],
    )


def _one(engine: Scan, now: Record, later: Record, xs: Array, Ps: Array) -> tuple[Array, Array]:
    """C = P Fᵀ (P⁻)⁻¹, x + C (xs − x⁻), (I − C F) P (I − C F)ᵀ + C (Q + Ps) Cᵀ."""
    x, P = now.x[0], now.P[0]
    n = x.shape[1]
    ahead, F, Q = engine.modes[0].linearise(later.dt, x, P, later.input)
    FP = F @ P
    P_ahead = _grown(_symmetric(FP @ F.transpose(0, 2, 1) + Q))
    root = native.root(P_ahead)
    C = native.solve(root, native.solve(root, FP), transposed=True).transpose(0, 2, 1)
    G = np.eye(n) - C @ F
    smoothed = x + _times(C, xs - ahead)
    return smoothed, _symmetric(G @ P @ G.transpose(0, 2, 1) + C @ (Q + Ps) @ C.transpose(0, 2, 1))


class Several:
    """One step back of several modes: their smoothed estimates, probabilities and messages."""

    def __init__(self, engine: Scan, now: Record, later: Record, messages: Messages) -> None:
        self.engine, self.now, self.later = engine, now, later
        self.modes = range(len(engine.modes))
        self._next = [self._add_measurements(j, messages.J[j], messages.h[j], messages.s[j]) for j in self.modes]
        self._roots = [native.root(P) for P in now.P]
        pi = engine.transition(later.dt)
        link = np.log(np.maximum(pi * now.probability[:, :, None], LEAST))
        pairs = [[self._pair(i, j, link[:, i, j]) for j in self.modes] for i in self.modes]
        self.x, self.P, self.messages = [], [], Messages([], [], [])
        weights = [np.stack([p.log_weight for p in row], axis=1) for row in pairs]
        totals = np.stack([_log_sum(w) for w in weights], axis=1)  # of each mode's pairs together
        log_probability = totals - _log_sum(totals)[:, None]
        self.probability = np.exp(log_probability)
        for i in self.modes:
            self._collapse(i, pairs[i], np.exp(weights[i] - totals[:, i : i + 1]), log_probability[:, i])

    def _add_measurements(self, j: int, J: Array, h: Array, s: Array) -> tuple[Array, Array, Array]:
        """What the scan after measured, as seen by mode j, added to its message."""
        x, P = self.later.x[j], self.later.P[j]
        for views, m in zip(self.engine.views, self.later.measurements, strict=True):
            y, H, _ = views[j].linearise(x, P, m.z, m.present, unscented=False)
            both = m.present[:, :, None] & m.present[:, None, :]
            R = np.where(both, m.R, np.eye(y.shape[1]))
            root = native.root(R)
            y = native.solve(root, np.where(m.present, y, 0.0)[:, :, None])[:, :, 0]
            H = native.solve(root, np.where(m.present[:, :, None], H, 0.0))
            s = s - 0.5 * (y * y).sum(axis=1)
            h = h + _times(H.transpose(0, 2, 1), y)
            J = J + H.transpose(0, 2, 1) @ H
        return J, h, s

    def _pair(self, i: int, j: int, log_link: Array) -> Pair:
        engine, now, later = self.engine, self.now, self.later
        at = engine.places(j, i)
        x, P = engine.source(j, i, now.x, now.P)
        ahead, F, Q = engine.modes[j].linearise(later.dt, x, P, later.input)
        lacking = at < 0
        if lacking.any():  # the covariance of what mode i does not have
            V = np.where(lacking[:, None] & lacking, P, 0.0)
            Q = Q + F @ V @ F.transpose(0, 2, 1)
        J, h, s = self._next[j]  # moved from mode j's filtered estimate to the prediction from mode i
        d = ahead - later.x[j]
        Jd = _times(J, d)
        s = s + ((h - 0.5 * Jd) * d).sum(axis=1)
        J, h, s = _integrate(J, h - Jd, s, Q)
        A = np.zeros((len(x), now.x[i].shape[1], len(at)))
        A[:, at[~lacking], :] = F.transpose(0, 2, 1)[:, ~lacking]
        J, h = _symmetric(A @ J @ A.transpose(0, 2, 1)), _times(A, h)
        fused, log_det = _parallel_sum(self._roots[i], J)
        moved = _times(fused, h)
        return Pair(J, h, now.x[i] + moved, fused, log_link + s + 0.5 * ((h * moved).sum(axis=1) - log_det))

    def _collapse(self, i: int, pairs: list[Pair], share: Array, log_weight: Array) -> None:
        """Mode i's smoothed estimate over its pairs, matched in two moments; its message.

        Where the pairs disagree the averaged message would be too sure of itself: its covariance grows by
        their spread about the smoothed mean, its peak stays.
        """
        x = sum(share[:, j, None] * p.x for j, p in enumerate(pairs))
        h = sum(share[:, j, None] * p.h for j, p in enumerate(pairs))
        J = sum(share[:, j, None, None] * p.J for j, p in enumerate(pairs))
        P = sum(share[:, j, None, None] * p.P for j, p in enumerate(pairs))
        away = np.stack([p.x - x for p in pairs], axis=1)
        spread = np.einsum("bj,bjr,bjq->brq", share, away, away)
        J, h, _ = _integrate(np.asarray(J), np.asarray(h), np.zeros(len(away)), spread)
        fused, log_det = _parallel_sum(self._roots[i], J)
        gain = (h * _times(fused, h)).sum(axis=1)
        mine = np.maximum(self.now.probability[:, i], LEAST)
        self.x.append(np.asarray(x))
        self.P.append(_grown(P + spread))
        self.messages.J.append(J)
        self.messages.h.append(h)
        self.messages.s.append(log_weight - np.log(mine) - 0.5 * (gain - log_det))


def _log_sum(log_weights: Array) -> Array:
    most = log_weights.max(axis=1)
    return most + np.log(np.exp(log_weights - most[:, None]).sum(axis=1))


def _integrate(J: Array, h: Array, s: Array, Q: Array) -> tuple[Array, Array, Array]:
    """The message before noise of covariance Q, with J = R Rᵀ, h = R g and C Cᵀ = I + Rᵀ Q R.

    J ← R (C Cᵀ)⁻¹ Rᵀ, h ← R (C Cᵀ)⁻¹ g: nothing large is subtracted, however large the noise.
    """
    R = native.root(J, semidefinite=True)
    real = np.einsum("bii->bi", R) > 0  # h has nothing where R has a column of zeros
    solvable = R.copy()
    np.einsum("bii->bi", solvable)[~real] = 1.0
    g = np.where(real, native.solve(solvable, h[:, :, None])[:, :, 0], 0.0)
    W, C = _halves(R, Q)
    after = native.solve(C, g[:, :, None])[:, :, 0]
    s = s + 0.5 * ((g * g).sum(axis=1) - (after * after).sum(axis=1) - _log_det(C))
    return _symmetric(W.transpose(0, 2, 1) @ W), _times(W.transpose(0, 2, 1), after), s


def _parallel_sum(L: Array, J: Array) -> tuple[Array, Array]:
    """(P⁻¹ + J)⁻¹ = L (I + Lᵀ J L)⁻¹ Lᵀ with P = L Lᵀ, and log det(I + P J)."""
    W, C = _halves(L, J)
    return _symmetric(W.transpose(0, 2, 1) @ W), _log_det(C)


def _halves(L: Array, J: Array) -> tuple[Array, Array]:
    """C Cᵀ = I + Lᵀ J L and W = C⁻¹ Lᵀ."""
    across = L.transpose(0, 2, 1)
    C = native.root(np.eye(L.shape[1]) + across @ J @ L, least=1.0)
    return native.solve(C, across), C


def _log_det(C: Array) -> Array:
    return 2.0 * np.log(np.einsum("bii->bi", C)).sum(axis=1)


def _times(A: Array, x: Array) -> Array:
    return (A @ x[:, :, None])[:, :, 0]


def _symmetric(P: Array) -> Array:
    return 0.5 * (P + P.transpose(0, 2, 1))


def _grown(P: Array) -> Array:
    """The diagonal raised by what rounding may have cost."""
    n = P.shape[1]
    np.einsum("bii->bi", P)[:] *= 1.0 + 4.0 * n * EPS
    return P
