"""NNVSMM trained on what counts: the tracking error itself, through the filter."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..checks import Array
from ..models.noise_network import NoiseNetwork
from .data import Runs
from .descent import Adam, Kept, clipped
from .mlp import Parameters, as_network, initial
from .noise import Rollout


def train_end_to_end(
    training: Runs,
    validation: Runs,
    *,
    least: float = 1.0,
    most: float = 196.0,
    hidden: int = 16,
    steps: int = 600,
    batch: int = 128,
    rate: float = 0.02,
    patience: int = 300,
    start: float | None = None,
    velocity_share: float = 0.0,
    seed: int = 0,
    progress: Callable[[int, float], None] | None = None,
) -> NoiseNetwork:
    """A noise network (log q, log NIS in; log q out) that makes the position errors of the filter it steers small.

    Loss: the mean over runs of log(mean over scans of the squared distance + R), so that easy and hard targets count
    alike; Adam on batches, gradients through all scans by :class:`jink.learn.noise.Rollout`, clipped to norm 1. The
    parameters that do best on the validation runs, looked at after every tenth step, are kept; ``patience`` steps
    without better ones end the training. Before the first update the last noise is ``start``, by default ``least``.
    velocity_share of the loss is the same of the velocity's errors, with 2 R/T² for R: without it a network may buy
    position with velocity, by noise that follows every measurement.
    """
    rng = np.random.default_rng(seed)
    centre, scale = (0.5 * np.log(least * most), -0.5, -0.5), (0.25 * np.log(most / least), 2.0, 2.0)
    values = initial([3, hidden, 1], rng)
    values[-2] *= 0.1
    model = NoiseNetwork(
        network=as_network(values),
        inputs="log-nis",
        output="log-variance",
        centre=centre,
        scale=scale,
        least=least,
        most=most,
        start=least if start is None else start,
        sensor_sd=training.sd,
    )
    checked = Rollout(model, validation)
    kept: Kept[Parameters] = Kept()
    adam = Adam(rate)
    last = 0
    for step in range(steps):
        some = training.take(rng.choice(len(training), min(batch, len(training)), replace=False))
        rollout = Rollout(model, some)
        _, slopes = _loss(rollout.forward(values), some, velocity_share)
        now = 0.5 * rate * (1 + np.cos(np.pi * step / steps))
        values = adam.step(values, clipped(rollout.backward(values, *slopes)), now)
        if step % 10 == 9 or step == steps - 1:
            if kept.offer(_loss(checked.forward(values), validation, velocity_share)[0], values):
                last = step
            if progress:
                progress(step, kept.loss)
            if step - last >= patience:
                break
    return replace(model, network=as_network(kept.value))


def _loss(estimated: tuple[Array, Array, Array], runs: Runs, velocity_share: float) -> tuple[float, list[Array]]:
    """The loss and its slopes in the positions and, where these have a share, the velocities (B, S, 2)."""
    step = np.diff(runs.time, axis=1).mean()
    parts = [(1 - velocity_share, estimated[0], runs.position, runs.sd**2)]
    if velocity_share:
        parts.append((velocity_share, estimated[1], runs.velocity, 2 * (runs.sd / step) ** 2))
    losses, slopes = zip(*(_part(*part) for part in parts), strict=True)
    return float(sum(losses)), list(slopes)


def _part(share: float, found: Array, truth: Array, floor: float, first: int = 2) -> tuple[float, Array]:
    error = np.nan_to_num(found - truth)
    error[:, :first] = 0.0
    B, S = error.shape[:2]
    squares = (error**2).sum(axis=(1, 2)) / (S - first) + floor
    return share * float(np.log(squares).mean()), share * 2 * error / (squares[:, None, None] * (S - first) * B)
