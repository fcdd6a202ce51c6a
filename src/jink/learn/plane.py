"""Corrections in the plane, learned on random families: see docs/corrector.md."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..catalogue.choose import default_filter
from ..checks import Array
from ..models.plane_corrector import ANSWERS, ODD, PlaneCorrector
from .descent import Adam, Kept
from .plane_families import RUNS, SPREADS, family
from .plane_inputs import Pairs, pairs_of

Parameters = list[Array]  # as PlaneCorrector.LAYERS
LIMIT = 4.0  # sds of an input that the network sees
QUANTILES = (0.001, 0.999)  # of an input: the range of the training
FAMILIES, HIDDEN, EPOCHS, BATCH, RATE = 1000, 32, 12, 2048, 0.004
CHECK = 0.1  # share of families that training does not see
NEES_SHARE, LARGEST = 0.02, 0.7
FEWEST = 20  # families


def drawn(kind: str, families: int, seed: int, progress: Callable[[str, int, int], None] | None = None) -> list[Pairs]:
    """Rows of every family, on the default filter of the kind. Errors: ValueError for a kind that has no families."""
    if kind not in SPREADS:
        raise ValueError(f"kind: random families are those of {', '.join(SPREADS)}, got {kind!r}")
    rng, out = np.random.default_rng([seed, 1]), []
    for k in range(families):
        scenario = family(kind, rng)
        made = scenario.simulate(RUNS, int(rng.integers(2**31)))
        sd = float(scenario.observation.sensor.sd)  # type: ignore[union-attr]
        filter = default_filter(kind, scenario.observation.sensor)
        time = np.broadcast_to(made.time, made.z.shape[:2])
        truth = made.truth.position, made.truth.velocity, made.truth.acceleration
        out.append(pairs_of(filter, time, made.z, sd**2 * np.eye(2), *truth, weighing=SPREADS[kind].weighing))
        if progress:
            progress("simulating families", k + 1, families)
    return out


def fit_plane(
    kind: str,
    *,
    families: int = FAMILIES,
    hidden: int = HIDDEN,
    epochs: int = EPOCHS,
    seed: int = 0,
    memory: bool = True,
    more: tuple[list[Pairs], list[Pairs]] = ((), ()),  # type: ignore[assignment]
    progress: Callable[[str, int, int], None] | None = None,
) -> PlaneCorrector:
    """A correction of the kind's default filter; the epoch that does best on unseen families is kept.

    memory: whether the network sees what is remembered of earlier scans; more: further rows to learn from and to check
    on. Errors: ValueError for other kinds than those
    of ``SPREADS``, or for too few families.
    """
    if families < FEWEST:
        raise ValueError(f"families: expected at least {FEWEST}, got {families}")
    parts = drawn(kind, families, seed, progress)
    unseen = max(2, round(CHECK * families))
    training, check = Pairs.joined([*parts[unseen:], *more[0]]), Pairs.joined([*parts[:unseen], *more[1]])
    low, high, centre, scale = ranges(training)
    if not memory:
        scale = _without_memory(scale, training.even.shape[1])
    given = dict(low=low, high=high, centre=centre, scale=scale)
    scaled = [_scaled(pairs, *given.values()) for pairs in (training, check)]
    rng, kept = np.random.default_rng([seed, 2]), Kept[Parameters]()
    values = _initial(training.even.shape[1], hidden, rng)
    adam, steps = Adam(RATE), epochs * max(1, len(training) // BATCH)
    step = 0
    for epoch in range(epochs):
        order = rng.permutation(len(training))
        for rows in np.array_split(order, max(1, len(training) // BATCH)):
            rate = 0.5 * RATE * (1 + np.cos(np.pi * step / steps))
            values = adam.step(values, _shortened(_gradients(values, *(a[rows] for a in scaled[0]))), rate)
            step += 1
        kept.offer(_loss(values, *scaled[1]), values)
        if progress:
            progress(f"epoch, least loss {kept.loss:.4f}", epoch + 1, epochs)
    layers = dict(zip(PlaneCorrector.LAYERS, (np.asarray(v, dtype=float) for v in kept.value), strict=True))
    arrays = {k: np.asarray(v).tolist() for k, v in (given | layers).items()}
    return PlaneCorrector(**arrays, fade=SPREADS[kind].fade)


def left_over(corrector: PlaneCorrector, pairs: Pairs) -> tuple[float, float]:
    """RMS error of position and velocity with the correction over that without, as every track weighs the same."""
    values = [np.asarray(getattr(corrector, name)) for name in PlaneCorrector.LAYERS]
    u, w, error, weight, _ = _scaled(
        pairs, *(np.asarray(v) for v in (corrector.low, corrector.high, corrector.centre, corrector.scale))
    )
    said = _forward(values, u, w)[0]
    after, before = ((weight * e**2).reshape(-1, 2, 2).sum(axis=(0, 2)) for e in (error - said, error))
    position, velocity = np.sqrt(after / before).tolist()
    return position, velocity


def ranges(pairs: Pairs) -> tuple[Array, Array, Array, Array]:
    """Low, high, centre and scale of each input; those of odd ones are even about zero."""
    even_low, even_high = np.quantile(pairs.even, QUANTILES, axis=0)
    odd_high = np.quantile(np.abs(pairs.odd), QUANTILES[1], axis=0)
    centre, scale = pairs.even.mean(axis=0), pairs.even.std(axis=0) + 1e-6
    odd_scale = np.sqrt((pairs.odd**2).mean(axis=0)) + 1e-6
    low, high = np.r_[even_low, -odd_high], np.r_[even_high, odd_high]
    return low, np.maximum(high, low + 1e-6), np.r_[centre, np.zeros(ODD)], np.r_[scale, odd_scale]


def _without_memory(scale: Array, even: int) -> Array:
    """Inputs of the memory scaled to nothing: two sums along, two averages, two sums across."""
    modes = (even - 12) // 2
    out = scale.copy()
    out[[6 + modes, 7 + modes, even - 2, even - 1, even + ODD - 2, even + ODD - 1]] = 1e9
    return out


def _scaled(pairs: Pairs, low: Array, high: Array, centre: Array, scale: Array) -> tuple[Array, ...]:
    u = (np.clip(np.hstack([pairs.even, pairs.odd]), low, high) - centre) / scale
    n = pairs.even.shape[1]
    columns = u[:, :n], u[:, n:], pairs.error, pairs.weight, pairs.inverse
    return tuple(a.astype(np.float32) for a in columns)  # type: ignore[return-value]


def _initial(even: int, hidden: int, rng: np.random.Generator) -> Parameters:
    first = 1 / np.sqrt(even + ODD)
    last = 0.1 / np.sqrt(hidden)
    shapes = ((hidden, even), first), ((hidden, ODD), first), ((ANSWERS[0], hidden), last), ((ANSWERS[1], hidden), last)
    A, B, V, W = (size * rng.standard_normal(shape) for shape, size in shapes)
    values = [A, B, np.zeros(hidden), V, np.zeros(ANSWERS[0]), W]
    return [a.astype(np.float32) for a in values]


def _forward(values: Parameters, u: Array, w: Array) -> tuple[Array, Array, tuple[Array, ...]]:
    """Corrections (N, 4), log factor (N,), and what the gradient needs."""
    A, B, b, V, v, W = values
    s, t = u @ A.T + b, w @ B.T
    plus, minus = np.maximum(s + t, 0), np.maximum(s - t, 0)
    total, difference = 0.5 * (plus + minus), 0.5 * (plus - minus)
    even, odd = total @ V.T + v, difference @ W.T
    return (
        np.stack([even[:, 0], odd[:, 0], even[:, 1], odd[:, 1]], axis=1),
        even[:, 2],
        (plus, minus, total, difference),
    )


def _parts(values: Parameters, u: Array, w: Array, error: Array, weight: Array, inverse: Array) -> tuple[Array, ...]:
    """Corrections left over, scaled NEES and log factor."""
    said, factor, layers = _forward(values, u, w)
    left = said - error
    factor = np.clip(factor, -LARGEST, LARGEST)
    nees = np.minimum(np.einsum("ni,nij,nj->n", left, inverse, left), 100.0) * np.exp(-2 * factor)
    return left, nees, factor, layers  # type: ignore[return-value]


def _loss(values: Parameters, u: Array, w: Array, error: Array, weight: Array, inverse: Array) -> float:
    """Σ weight (c − error)² / 2 + share · (NEES/2 + 4 ln factor), per row."""
    left, nees, factor, _ = _parts(values, u, w, error, weight, inverse)
    return float((0.5 * weight * left**2).sum(axis=1).mean() + NEES_SHARE * (0.5 * nees + 4 * factor).mean())


def _gradients(values: Parameters, u: Array, w: Array, error: Array, weight: Array, inverse: Array) -> list[Array]:
    """Of the loss; the correction does not care for the NEES."""
    _, _, _, V, _, W = values
    left, nees, factor, (plus, minus, total, difference) = _parts(values, u, w, error, weight, inverse)
    slope = weight * left / len(u)
    of_factor = np.where(np.abs(factor) < LARGEST, NEES_SHARE * (4 - nees), 0.0) / len(u)
    even = np.stack([slope[:, 0], slope[:, 2], of_factor], axis=1).astype(np.float32)
    odd = slope[:, 1::2]
    to_total, to_difference = 0.5 * even @ V, 0.5 * odd @ W
    to_plus, to_minus = (to_total + to_difference) * (plus > 0), (to_total - to_difference) * (minus > 0)
    to_s, to_t = to_plus + to_minus, to_plus - to_minus
    return [to_s.T @ u, to_t.T @ w, to_s.sum(axis=0), even.T @ total, even.sum(axis=0), odd.T @ difference]


def _shortened(gradients: list[Array], most: float = 0.5) -> list[Array]:
    norm = np.sqrt(sum(float((g * g).sum()) for g in gradients))
    return [g * min(1.0, most / norm) for g in gradients] if norm > 0 else gradients
