"""Corrections in the plane, learned on random families: see docs/corrector.md."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from ..catalogue.choose import default_filter
from ..checks import Array
from ..models.plane_corrector import ODD, PlaneCorrector
from .descent import Adam, Kept
from .plane_families import RUNS, SPREADS, family
from .plane_inputs import Pairs, pairs_of
from .plane_layers import Parameters, Scans, finished, forward, gradients, initial, loss, parameters

QUANTILES = (0.001, 0.999)  # of an input: the range of the training
FAMILIES, HIDDEN, EPOCHS, RATE = 1000, 32, 12, 0.004
KEPT = 8  # quantities of each kind that the network remembers
WINDOW, BATCH = 140, 32  # scans that gradients go back through, and windows at a time
CHECK = 0.1  # share of families that training does not see
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

    memory: whether the network sees or keeps anything of earlier scans; more: further rows to learn from and to check
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
    learned, checked = (_Windows(pairs, *given.values()) for pairs in (training, check))
    rng, kept = np.random.default_rng([seed, 2]), Kept[Parameters]()
    values = initial(training.even.shape[1], hidden, KEPT if memory else 0, rng)
    batches = max(1, len(learned) // BATCH)
    adam, steps = Adam(RATE), epochs * batches
    step = 0
    for epoch in range(epochs):
        for some in np.array_split(rng.permutation(len(learned)), batches):
            rate: Any = np.float32(0.5 * RATE * (1 + np.cos(np.pi * step / steps)))
            values = adam.step(values, _shortened(gradients(values, learned.scans(some))), rate)
            step += 1
        kept.offer(checked.loss(values), values)
        if progress:
            progress(f"epoch, least loss {kept.loss:.4f}", epoch + 1, epochs)
    arrays: dict[str, Any] = {k: np.asarray(v).tolist() for k, v in given.items()}
    arrays |= finished(kept.value)
    return PlaneCorrector(**arrays, fade=SPREADS[kind].fade)


def left_over(corrector: PlaneCorrector, pairs: Pairs) -> tuple[float, float]:
    """RMS error of position and velocity with the correction over that without, as every track weighs the same."""
    ranges = (np.asarray(v) for v in (corrector.low, corrector.high, corrector.centre, corrector.scale))
    values, windows = parameters(corrector), _Windows(pairs, *ranges)
    after, before = np.zeros(4), np.zeros(4)
    for d in windows.all():
        left = forward(values, d.u, d.w)[0] - d.error
        after += (d.weight * left**2).sum(axis=(0, 1))
        before += (d.weight * d.error**2).sum(axis=(0, 1))
    position, velocity = np.sqrt(after.reshape(2, 2).sum(axis=1) / before.reshape(2, 2).sum(axis=1)).tolist()
    return position, velocity


def ranges(pairs: Pairs) -> tuple[Array, Array, Array, Array]:
    """Low, high, centre and scale of each input; those of odd ones are even about zero."""
    pairs = pairs.some(pairs.weight[:, 0] > 0)
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


class _Windows:
    """Rows of tracks, scaled, cut into windows of up to ``WINDOW`` that follow each other on one track."""

    def __init__(self, pairs: Pairs, low: Array, high: Array, centre: Array, scale: Array) -> None:
        u = (np.clip(np.hstack([pairs.even, pairs.odd]), low, high) - centre) / scale
        n = pairs.even.shape[1]
        columns = u[:, :n], u[:, n:], pairs.error, pairs.weight, pairs.inverse
        self.columns: list[Any] = [a.astype(np.float32) for a in columns]
        first = np.flatnonzero(pairs.begins)
        age = np.arange(len(pairs)) - first[np.cumsum(pairs.begins) - 1]
        self.first = np.flatnonzero(age % WINDOW == 0)
        self.length = np.diff(np.r_[self.first, len(pairs)])

    def __len__(self) -> int:
        return len(self.first)

    def scans(self, which: np.ndarray) -> Scans:
        """Of some windows; what a shorter one lacks does not count."""
        steps = np.arange(self.length[which].max())[:, None]
        rows = self.first[which] + np.minimum(steps, self.length[which] - 1)
        u, w, error, weight, inverse = (a[rows] for a in self.columns)
        weight[steps >= self.length[which]] = 0
        return Scans(u, w, error, weight, inverse)

    def all(self, at_once: int = 256) -> Iterator[Scans]:
        """One part after the other."""
        for k in range(0, len(self), at_once):
            yield self.scans(np.arange(k, min(k + at_once, len(self))))

    def loss(self, values: Parameters) -> float:
        """Per row that counts."""
        sums = np.array([loss(values, scans) for scans in self.all()]).sum(axis=0)
        return float(sums[0] / sums[1])


def _shortened(gradients: list[Array], most: float = 0.5) -> list[Array]:
    norm = np.sqrt(sum(float((g * g).sum()) for g in gradients))
    return [g * min(1.0, most / norm) for g in gradients] if norm > 0 else gradients
