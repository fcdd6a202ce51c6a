"""The network of a correction in the plane: its answers over windows of scans, and gradients by hand."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..checks import Array
from ..frozen import frozen
from ..models.plane_corrector import ANSWERS, BOUND, ODD, PlaneCorrector

Parameters = list[Array]  # as PlaneCorrector.LAYERS; instead of keep its logit
NEES_SHARE, LARGEST = 0.02, 0.7


@frozen(eq=False)
class Scans:
    """Windows (T, N) of scans to learn from: scaled even inputs u, odd ones w, error, weight and inverse as Pairs."""

    u: Array
    w: Array
    error: Array
    weight: Array
    inverse: Array

    @property
    def counts(self) -> np.ndarray:
        """Which of them count."""
        return self.weight[..., 0] > 0


def initial(even: int, hidden: int, kept: int, rng: np.random.Generator) -> Parameters:
    """Small random weights."""
    first, last, recall = 1 / np.sqrt(even + ODD + 2 * kept), 0.1 / np.sqrt(hidden), 0.3 / np.sqrt(hidden)

    def drawn(size: float, *shape: int) -> Array:
        return size * rng.standard_normal(shape)

    values: list[Any] = [
        *(drawn(first, hidden, even + kept), drawn(first, hidden, ODD + kept), np.zeros(hidden)),
        *(drawn(last, ANSWERS[0], hidden), np.zeros(ANSWERS[0]), drawn(last, ANSWERS[1], hidden)),
        *(np.zeros(kept), drawn(recall, kept, hidden), np.zeros(kept), drawn(recall, kept, hidden)),
    ]
    return [a.astype(np.float32) for a in values]


def finished(values: Parameters) -> dict[str, list]:
    """As a PlaneCorrector takes them."""
    out = [np.asarray(v, dtype=float) for v in values]
    out[6] = 1 / (1 + np.exp(-out[6]))
    return {name: v.tolist() for name, v in zip(PlaneCorrector.LAYERS, out, strict=True)}


def parameters(corrector: PlaneCorrector) -> Parameters:
    """The other way round."""
    hidden, kept = corrector.hidden, len(corrector.keep)
    values: list[Any] = [np.asarray(getattr(corrector, name), dtype=np.float32) for name in PlaneCorrector.LAYERS]
    values[6] = np.log(values[6] / (1 - values[6]))
    values[7], values[9] = (values[k].reshape(kept, hidden) for k in (7, 9))
    return values


def forward(values: Parameters, u: Array, w: Array) -> tuple[Array, Array, tuple[Array, ...]]:
    """Corrections (T, N, 4), log factor (T, N), and what the gradient needs."""
    A, B, b, V, v, W, logit, G, g, K = values
    kept, (T, N) = len(logit), u.shape[:2]
    keep = 1 / (1 + np.exp(-logit))
    seen_u, seen_w = (np.concatenate([a, np.zeros((T, N, kept), a.dtype)], axis=-1) for a in (u, w))
    n, m = u.shape[-1], w.shape[-1]
    s_all, t_all = u @ A[:, :n].T + b, w @ B[:, :m].T
    plus, minus = np.empty_like(s_all), np.empty_like(s_all)
    said_u, said_w = (np.empty((T, N, kept), u.dtype) for _ in range(2))
    own_A, own_B, half_G, half_K = A[:, n:].T.copy(), B[:, m:].T.copy(), 0.5 * G.T, 0.5 * K.T
    a, o = (np.zeros((N, kept), u.dtype) for _ in range(2))
    for k in range(T):
        seen_u[k, :, n:], seen_w[k, :, m:] = a, o
        s, t = s_all[k] + a @ own_A, t_all[k] + o @ own_B
        p, q = np.maximum(s + t, 0, out=plus[k]), np.maximum(s - t, 0, out=minus[k])
        said_u[k], said_w[k] = (p + q) @ half_G + g, (p - q) @ half_K
        a = keep * a + (1 - keep) * np.minimum(np.maximum(said_u[k], -BOUND), BOUND)
        o = keep * o + (1 - keep) * np.minimum(np.maximum(said_w[k], -BOUND), BOUND)
    total, difference = 0.5 * (plus + minus), 0.5 * (plus - minus)
    even, odd = total @ V.T + v, difference @ W.T
    said = np.stack([even[..., 0], odd[..., 0], even[..., 1], odd[..., 1]], axis=-1)
    return said, even[..., 2], (seen_u, seen_w, plus, minus, total, difference, said_u, said_w)


def _parts(values: Parameters, d: Scans) -> tuple[Array, Array, Array, tuple[Array, ...]]:
    """Corrections left over, scaled NEES, log factor, and what the gradient needs."""
    said, factor, layers = forward(values, d.u, d.w)
    left = said - d.error
    factor = np.clip(factor, -LARGEST, LARGEST)
    square = ((d.inverse @ left[..., None])[..., 0] * left).sum(axis=-1)
    return left, np.minimum(square, 100.0) * np.exp(-2 * factor), factor, layers


def loss(values: Parameters, d: Scans) -> tuple[float, int]:
    """Σ weight (c − error)² / 2 + share · (NEES/2 + 4 ln factor) of the scans that count, and how many these are."""
    left, nees, factor, _ = _parts(values, d)
    squares = (0.5 * d.weight * left**2).sum()
    return float(squares + NEES_SHARE * ((0.5 * nees + 4 * factor) * d.counts).sum()), int(d.counts.sum())


def gradients(values: Parameters, d: Scans) -> list[Array]:
    """Of the loss per scan that counts; the correction does not care for the NEES."""
    V, W = values[3], values[5]
    left, nees, factor, layers = _parts(values, d)
    seen_u, seen_w, _, _, total, difference, _, _ = layers
    share = np.float32(1.0 / max(1, d.counts.sum()))
    slope = d.weight * left * share
    of_factor = np.where((np.abs(factor) < LARGEST) & d.counts, NEES_SHARE * (4 - nees), 0.0) * share
    even = np.stack([slope[..., 0], slope[..., 2], of_factor], axis=-1).astype(left.dtype)
    odd = slope[..., 1::2]
    to_s, to_t, to_a, to_o, of_keep = _backwards(values, layers, even @ V, odd @ W)
    flat = [
        a.reshape(left.shape[0] * left.shape[1], a.shape[-1])
        for a in (to_s, to_t, seen_u, seen_w, even, odd, total, difference, to_a, to_o)
    ]
    to_s, to_t, seen_u, seen_w, even, odd, total, difference, to_a, to_o = flat
    return [
        *(to_s.T @ seen_u, to_t.T @ seen_w, to_s.sum(axis=0)),
        *(even.T @ total, even.sum(axis=0), odd.T @ difference),
        *(of_keep, to_a.T @ total, to_a.sum(axis=0), to_o.T @ difference),
    ]


def _backwards(values: Parameters, layers: tuple[Array, ...], of_total: Array, of_difference: Array) -> list[Array]:
    """Slopes by s, by t, by what is recalled, and by the logit of keep; those by the answers are given."""
    A, B, *_, logit, G, _, K = values
    seen_u, seen_w, plus, minus, _, _, said_u, said_w = layers
    kept, (T, N) = len(logit), plus.shape[:2]
    keep = 1 / (1 + np.exp(-logit))
    n, m = seen_u.shape[-1] - kept, seen_w.shape[-1] - kept
    own_A, own_B = A[:, n:].copy(), B[:, m:].copy()
    to_s, to_t, to_a, to_o = np.empty_like(plus), np.empty_like(plus), np.empty_like(said_u), np.empty_like(said_w)
    within = [np.abs(a) < BOUND for a in (said_u, said_w)]
    of_keep, a, o = np.zeros(kept, plus.dtype), *(np.zeros((N, kept), plus.dtype) for _ in range(2))
    for k in reversed(range(T)):  # a and o: slopes by what the scan after this one sees
        for later, seen, first, said in ((a, seen_u, n, said_u), (o, seen_w, m, said_w)):
            of_keep += (later * (seen[k, :, first:] - np.minimum(np.maximum(said[k], -BOUND), BOUND))).sum(axis=0)
        np.multiply((1 - keep) * a, within[0][k], out=to_a[k])
        np.multiply((1 - keep) * o, within[1][k], out=to_o[k])
        total, difference = of_total[k] + to_a[k] @ G, of_difference[k] + to_o[k] @ K
        p, q = 0.5 * (total + difference) * (plus[k] > 0), 0.5 * (total - difference) * (minus[k] > 0)
        np.add(p, q, out=to_s[k])
        np.subtract(p, q, out=to_t[k])
        a, o = keep * a + to_s[k] @ own_A, keep * o + to_t[k] @ own_B
    return [to_s, to_t, to_a, to_o, of_keep * keep * (1 - keep)]
