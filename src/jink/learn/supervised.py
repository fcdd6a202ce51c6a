"""NNVSMM trained on labels, as in choi-2001: which of a bank of filters was best at each scan."""

from __future__ import annotations

import numpy as np

from ..checks import Array
from ..frozen import frozen
from ..models.noise_network import LEAST_NIS, NoiseNetwork
from .data import Runs
from .mlp import fit_network

LEVELS = np.arange(1.0, 197.0, 5.0)  # 1, 6, … 196: the paper's 40 levels, in units of its sensor's sd²/T⁴


@frozen(eq=False)
class Bank:
    """Filters of constant noise, (L, B, S, 2): squared error, residual, and its variance (L, B, S); from the third scan
    on.
    """

    levels: Array
    error: Array
    residual: Array
    S: Array


def bank_of(runs: Runs, levels: Array = LEVELS) -> Bank:
    """Each level's constant-velocity filter along every axis of the runs, two-point start."""
    z, R = runs.z, runs.sd**2
    L, (B, scans, axes) = len(levels), z.shape
    T = np.diff(runs.time, axis=1)
    p = np.broadcast_to(z[:, 1], (L, B, axes))
    v = np.broadcast_to((z[:, 1] - z[:, 0]) / T[:, :1], (L, B, axes))
    P = [
        np.full((L, B), R),
        np.broadcast_to(R / T[:, 0], (L, B)),
        np.broadcast_to(2 * R / T[:, 0] ** 2, (L, B)),
    ]
    error, residual = np.full((2, L, B, scans, axes), np.nan)
    S = np.full((L, B, scans), np.nan)
    q = levels[:, None]
    for k in range(2, scans):
        t = T[:, k - 1]
        p = p + t[:, None] * v
        P[0] = P[0] + t * (2 * P[1] + t * P[2]) + t**4 / 4 * q
        P[1] = P[1] + t * P[2] + t**3 / 2 * q
        P[2] = P[2] + t**2 * q
        r = z[:, k] - p
        S[:, :, k], residual[:, :, k] = P[0] + R, r
        p, v = p + (P[0] / S[:, :, k])[..., None] * r, v + (P[1] / S[:, :, k])[..., None] * r
        P = [R * P[0] / S[:, :, k], R * P[1] / S[:, :, k], P[2] - P[1] ** 2 / S[:, :, k]]
        error[:, :, k] = (p - runs.position[:, k]) ** 2
    return Bank(levels, error, residual, S)


def sensor_levels(runs: Runs) -> Array:
    """The paper's levels (m²/s⁴) for another sensor: in units of sd²/T⁴, which is one there."""
    return LEVELS * runs.sd**2 / float(np.nanmedian(np.diff(runs.time, axis=1))) ** 4


def published_pairs(runs: Runs, levels: Array = LEVELS) -> tuple[Array, Array]:
    """Inputs (N, 3) and labels (N,) as the paper has them, scan by scan and run by run.

    The best filter of the 40 by 40 has the level of least error along x and that of least error along y; its label is
    their mean, since the network says one number. Inputs: the label of the scan before (the lowest level at first), and
    along each axis the likelihood of the measurement under the filter that was best there at the scan before: at the
    scan itself nobody knows which it is.
    """
    bank = bank_of(runs, levels)
    rows = np.arange(len(runs))
    last, before = np.full(len(runs), bank.levels[0]), np.zeros((len(runs), 2), dtype=int)
    inputs, labels = [], []
    for k in range(2, runs.z.shape[1]):
        found = [_likelihood(bank, before[:, axis], rows, k, axis) for axis in range(2)]
        inputs.append(np.column_stack([last, *found]))
        before = bank.error[:, :, k].argmin(axis=0)
        last = bank.levels[before].mean(axis=1)
        labels.append(last)
    return np.concatenate(inputs), np.concatenate(labels)


def _likelihood(bank: Bank, i: np.ndarray, rows: np.ndarray, k: int, axis: int) -> Array:
    r, S = bank.residual[i, rows, k, axis], bank.S[i, rows, k]
    return np.exp(-0.5 * r * r / S) / np.sqrt(2 * np.pi * S)


def expected_pairs(runs: Runs, levels: Array = LEVELS) -> tuple[Array, Array]:
    """Inputs (N, 3) in logarithms and labels (N,) without the noise of one run.

    Label: the level whose mean squared error at the scan, over all runs of the same path, is least. Inputs: log of the
    label of the scan before, and log NIS along x and y of the filter of that label, which is what there is at run time.
    """
    bank = bank_of(runs, levels)
    _, path = np.unique(runs.position.reshape(len(runs), -1).round(6), axis=0, return_inverse=True)
    squares = bank.error.sum(axis=3)
    mean = np.stack([squares[:, path == each].mean(axis=1) for each in range(path.max() + 1)], axis=1)
    best = np.where(np.isnan(mean[0]), 0, np.nan_to_num(mean).argmin(axis=0))[path]  # (B, S) places of levels
    rows = np.arange(len(runs))
    before = np.zeros(len(runs), dtype=int)
    inputs, labels = [], []
    for k in range(2, runs.z.shape[1]):
        nis = bank.residual[before, rows, k] ** 2 / bank.S[before, rows, k][:, None]
        inputs.append(np.column_stack([np.log(bank.levels[before]), np.log(nis + LEAST_NIS)]))
        before = best[:, k]
        labels.append(bank.levels[before])
    return np.concatenate(inputs), np.concatenate(labels)


def train_supervised(
    training: Runs,
    validation: Runs,
    *,
    labels: str = "published",
    levels: Array = LEVELS,
    seed: int = 0,
    hidden: int = 16,
    epochs: int = 200,
) -> NoiseNetwork:
    """The parameter-based network by least squares on labels: "published" or "expected" pairs.

    levels (m²/s⁴), rising, are the noises of the bank. One hidden layer, as in the paper. Errors: ValueError for other
    labels, and for scans without a measurement.
    """
    least, most = float(levels[0]), float(levels[-1])
    if not all(np.isfinite(runs.z).all() for runs in (training, validation)):
        raise ValueError("labels: expected a measurement at every scan of tracks of one length")
    if labels not in ("published", "expected"):
        raise ValueError(f"labels: expected published or expected, got {labels!r}")
    make = published_pairs if labels == "published" else expected_pairs
    pairs = [make(runs, levels) for runs in (training, validation)]
    centre, scale = pairs[0][0].mean(axis=0), pairs[0][0].std(axis=0)
    middle, spread = float(pairs[0][1].mean()), float(pairs[0][1].std())

    def wanted(q: Array) -> Array:
        if labels == "published":
            return (q - middle) / spread
        share = np.clip(np.log(q / least) / np.log(most / least), 0.02, 0.98)  # the output is a logistic function
        return np.log(share / (1 - share))

    scaled = [((u - centre) / scale, wanted(q)[:, None]) for u, q in pairs]
    network = fit_network(*scaled[0], validation=scaled[1], hidden=(hidden,), epochs=epochs, seed=seed)
    published = labels == "published"
    return NoiseNetwork(
        network=network,
        inputs="likelihood" if published else "log-nis",
        output="variance" if published else "log-variance",
        centre=centre.tolist(),
        scale=scale.tolist(),
        least=least,
        most=most,
        start=least,
        sensor_sd=training.sd,
        output_centre=middle if published else 0.0,
        output_scale=spread if published else 1.0,
    )
