"""Correctors: what a filter leaves behind, learned from runs with their truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..catalogue.tuning import best_noise
from ..checks import Array
from ..estimate import Status
from ..filters.kalman import Kalman
from ..frozen import frozen
from ..metrics.figure import ratio_influence, spread
from ..models.corrector import CORRECTS, INPUTS, MOST_SD, MOST_SUMS, Corrector, history_of
from ..models.motion import ConstantAcceleration
from ..models.sensor import Position
from .anfis import fit_anfis
from .data import Runs
from .mlp import fit_network


@frozen(kw_only=True, eq=False)
class Seen:
    """What a filter saw and said at every scan, (B, S, axes) each.

    innovation ν = z − x̂(t|t−1) (m) and its variance S, R of it the measurement's; residual z − x̂(t|t); step
    x̂(t|t−1) − x̂(t|t); the estimate, and the variance of the prediction, by quantity (position, velocity,
    acceleration); P of the estimate along each axis, (B, S, axes, quantities, quantities) in that order; updated where
    a measurement was used; began where the track started, or started again.
    """

    innovation: Array
    S: Array
    R: Array
    residual: Array
    step: Array
    estimate: dict[str, Array]
    variance: dict[str, Array]
    P: Array
    updated: np.ndarray
    began: np.ndarray


def watch(filter: Any, runs: Runs) -> Seen:
    """Run a filter over runs, every scan once without its measurement and once with it.

    Over no time nothing moves, so the first gives x̂(t|t−1) and the second is what the filter says anyway.
    """
    B, S, axes = runs.z.shape
    z = np.full((B, S, 2, axes), np.nan)
    z[:, :, 1] = runs.z
    estimate = filter.filter(
        np.repeat(runs.time.reshape(-1), 2),
        z.reshape(-1, axes),
        offsets=np.arange(B + 1) * 2 * S,
        outputs=("x", "P", "status"),
    )
    x = estimate.x.reshape(B, S, 2, -1)
    P = estimate.P.reshape(B, S, 2, *estimate.P.shape[1:])
    status = estimate.status.reshape(B, S, 2)[:, :, 1, None]
    updated = (status == Status.updated) & np.isfinite(runs.z)
    places = _places(estimate.components, axes)
    p = places["position"]
    variance = np.einsum("...ii->...i", P[:, :, 0])
    along = np.array([*places.values()]).T
    return Seen(
        innovation=runs.z - x[:, :, 0, p],
        S=variance[..., p] + runs.sd**2,
        R=np.broadcast_to(runs.sd**2, runs.z.shape),
        residual=runs.z - x[:, :, 1, p],
        step=x[:, :, 0, p] - x[:, :, 1, p],
        estimate={name: x[:, :, 1, where] for name, where in places.items()},
        variance={name: variance[..., where] for name, where in places.items()},
        P=np.stack([P[:, :, 1][..., which[:, None], which] for which in along], axis=2),
        updated=updated,
        began=np.isin(status, (Status.initialised, Status.restarted)) & np.ones(runs.z.shape, dtype=bool),
    )


def _places(components: Sequence[str], axes: int) -> dict[str, list[int]]:
    """Where position, velocity and acceleration stand in an estimate, as far as it has them."""
    named = {quantity: [f"{quantity[0]}{axis}" for axis in "xyz"[:axes]] for quantity in CORRECTS}
    return {
        quantity: [components.index(name) for name in names]
        for quantity, names in named.items()
        if set(names) <= set(components)
    }


def inputs_of(kind: str, count: int, seen: Seen) -> Array:
    """A corrector's inputs u (B, S, axes, count); see :class:`jink.models.corrector.Corrector`."""
    if kind == "titi-guney":
        return np.where(seen.updated[..., None], np.stack([seen.residual, seen.step], axis=-1), 0.0)
    with np.errstate(invalid="ignore"):
        normal = np.where(seen.updated, seen.innovation / np.sqrt(seen.S), 0.0)
    length = history_of(kind, count)
    out = np.zeros((*normal.shape, length))
    past = np.zeros((len(normal), normal.shape[2], length))
    for k in range(normal.shape[1]):
        newer = np.concatenate([normal[:, k, :, None], past[..., :-1]], axis=-1)
        past = np.where(seen.updated[:, k, :, None], newer, np.where(seen.began[:, k, :, None], 0.0, past))
        out[:, k] = past
    if kind == "sums":
        lengths = 2 ** np.arange(count)
        return np.cumsum(out, axis=-1)[..., lengths - 1] / np.sqrt(lengths)
    return out


def unit_of(kind: str, corrects: Sequence[str], seen: Seen) -> Array:
    """What a correction of one means (B, S, axes, outputs), in SI units."""
    shape = (*seen.S.shape, len(corrects))
    if kind == "titi-guney":
        return np.ones(shape)
    with np.errstate(invalid="ignore", divide="ignore"):
        bounded = np.minimum(seen.S, MOST_SD**2 * seen.R)
        return np.stack([np.sqrt(bounded * seen.variance[c] / seen.variance["position"]) for c in corrects], axis=-1)


def correction(corrector: Corrector, seen: Seen) -> dict[str, Array]:
    """What to add to the estimate of each quantity, (B, S, axes); zero where nothing was measured."""
    u = inputs_of(corrector.inputs, corrector.count, seen)
    c = corrector(u.reshape(-1, corrector.count)).reshape(*u.shape[:-1], -1)
    c = np.where(seen.updated[..., None], c * unit_of(corrector.inputs, corrector.corrects, seen), 0.0)
    return {name: c[..., k] for k, name in enumerate(corrector.corrects)}


def fit_corrector(
    filter: Any,
    training: Runs,
    validation: Runs,
    *,
    model: str = "anfis",
    inputs: str = "titi-guney",
    count: int = 2,
    corrects: Sequence[str] = ("position",),
    seed: int = 0,
    **settings: Any,
) -> Corrector:
    """A corrector of this filter for targets like those of the training runs.

    model "anfis" (settings of :func:`jink.learn.anfis.fit_anfis`), "network" (those of
    :func:`jink.learn.mlp.fit_network`) or "linear", the weighted sum of the inputs and a constant that both have to
    beat; inputs and corrects as in :class:`jink.models.corrector.Corrector`; count, how many innovations or sums.
    Errors: ValueError naming what does not fit.
    """
    if inputs not in INPUTS:
        raise ValueError(f"inputs: expected one of {', '.join(INPUTS)}, got {inputs!r}")
    if inputs == "sums" and not 1 <= count <= MOST_SUMS:
        raise ValueError(f"count: expected 1 to {MOST_SUMS} sums, got {count}")
    if inputs == "titi-guney" and count != 2:
        raise ValueError(f"count: expected 2 inputs for titi-guney, got {count}")
    pairs = [_pairs(watch(filter, runs), runs, inputs, count, corrects) for runs in (training, validation)]
    u, y = pairs[0]
    centre, scale = u.mean(axis=0), np.maximum(u.std(axis=0), 1e-12)
    output_scale = np.maximum(y.std(axis=0), 1e-12)
    scaled = [((a - centre) / scale, b / output_scale) for a, b in pairs]
    if model == "anfis":
        fitted = fit_anfis(*scaled[0], validation=scaled[1], **settings)
    elif model == "network":
        fitted = fit_network(*scaled[0], validation=scaled[1], seed=seed, **settings)
    elif model == "linear":
        fitted = fit_anfis(*scaled[0], kind="triangular", functions=1, epochs=0, ridge=1e-9)
    else:
        raise ValueError(f"model: expected anfis, network or linear, got {model!r}")
    low, high = u.min(axis=0), u.max(axis=0)
    found = Corrector(
        model=fitted,
        inputs=inputs,
        low=low.tolist(),
        high=np.maximum(high, low + 1e-9).tolist(),
        centre=centre.tolist(),
        scale=scale.tolist(),
        output_scale=output_scale.tolist(),
        corrects=tuple(corrects),
    )
    return replace(found, sd_factors=sd_factors(filter, validation, found))


def weakened(filter: Any, runs: Runs, corrector: Corrector) -> tuple[Corrector, tuple[float, ...]]:
    """The corrector, each correction times a gain between 0 and 1, and these gains.

    A correction a of the error e leaves the least error at γ = Σ e a / Σ a². The gain is the least over the families of
    runs of γ − 2 standard errors, taken over their runs: an aid helps each kind of target that it is checked on, or is
    silent. A family of one run has no standard error.
    """
    seen = watch(filter, runs)
    gains = []
    for name, added in correction(corrector, seen).items():
        error = getattr(runs, name) - seen.estimate[name]
        good = seen.updated & np.isfinite(error)
        e, a = np.where(good, error, 0.0), np.where(good, added, 0.0)
        along, square = (e * a).sum(axis=(1, 2)), (a * a).sum(axis=(1, 2))
        bounds = [_least(along[runs.family == k], square[runs.family == k]) for k in np.unique(runs.family)]
        gains.append(min(max(min(bounds), 0.0), 1.0))
    scale = tuple(s * gain for s, gain in zip(corrector.output_scale, gains, strict=True))
    weak = replace(corrector, output_scale=scale)
    return replace(weak, sd_factors=sd_factors(filter, runs, weak)), tuple(gains)


def _least(along: Array, square: Array) -> float:
    """The lower end of Σ along / Σ square; one where there is no correction at all."""
    if not square.any():
        return 1.0
    gain, influence = ratio_influence(along, square)
    return gain - 2 * spread(influence) if len(along) > 1 else gain


def sd_factors(filter: Any, runs: Runs, corrector: Corrector) -> tuple[float, ...]:
    """Factors w of the sds of position, velocity and acceleration, as far as filter and truth have them, of the largest
    likelihood on the runs: for the errors e that the corrector leaves, N(e; 0, W P W).

    Position and velocity are taken together, so that their mean NEES is 1: with A = mean(P⁻¹ ∘ e eᵀ),
    wᵢ = √(Aᵢᵢ (1 + A₁₂ / √(A₁₁ A₂₂))). The acceleration is taken alone, w = √mean(e²/P).
    """
    seen = watch(filter, runs)
    added = correction(corrector, seen)
    names = [name for name in CORRECTS if name in seen.estimate and np.isfinite(getattr(runs, name)).any()]
    error = np.stack([seen.estimate[n] + added.get(n, 0.0) - getattr(runs, n) for n in names], axis=-1)
    good = seen.updated & np.isfinite(error).all(axis=-1)
    if not good.any():
        return ()
    e, P = error[good], seen.P[good]
    motion = min(len(names), 2)
    inverse = np.linalg.inv(P[:, :motion, :motion])
    A = np.mean(inverse * e[:, :motion, None] * e[:, None, :motion], axis=0)
    sds = np.sqrt(np.diag(A))
    shared = 1 + A[0, 1] / (sds[0] * sds[1]) if motion == 2 else 1.0
    alone = np.sqrt(np.mean(e[:, 2:] ** 2 / np.einsum("nii->ni", P)[:, 2 : len(names)], axis=0))
    return (*(sds * np.sqrt(shared)).tolist(), *alone.tolist())


def _pairs(seen: Seen, runs: Runs, inputs: str, count: int, corrects: Sequence[str]) -> tuple[Array, Array]:
    """Inputs (N, count) and wanted corrections (N, outputs) of all scans and axes with a measurement and a truth."""
    missing = [name for name in corrects if name not in seen.estimate]
    if missing:
        raise ValueError(f"corrects: expected what the filter estimates; it does not estimate {missing[0]}")
    u, unit = inputs_of(inputs, count, seen), unit_of(inputs, corrects, seen)
    error = np.stack([getattr(runs, name) - seen.estimate[name] for name in corrects], axis=-1)
    with np.errstate(invalid="ignore"):
        y = error / unit
    good = seen.updated & np.isfinite(y).all(axis=-1)
    return u[good], y[good]


def position_rms(filter: Any, runs: Runs, corrector: Corrector | None = None) -> Array:
    """RMS error (m) of the position along each axis, over the scans with a measurement, aided or not."""
    seen = watch(filter, runs)
    error = seen.estimate["position"] - runs.position
    if corrector is not None:
        error = error + correction(corrector, seen)["position"]
    good = seen.updated & np.isfinite(error)
    return np.array([np.sqrt(np.mean(error[..., a][good[..., a]] ** 2)) for a in range(runs.axes)])


def tuned_acceleration(training: Runs, slowness: float = 1.0) -> Kalman:
    """The constant-acceleration filter with the least position error on the runs, its noise then divided by
    slowness.
    """
    sensor = Position(sd=training.sd, axes=training.axes)

    def made(q: float) -> Kalman:
        return Kalman(ConstantAcceleration(jerk_psd=q, acceleration_prior_sd=10.0), sensor)

    q = best_noise(lambda q: float(position_rms(made(q), training).mean()), 1e-3, 1e4)
    return made(q / slowness)
