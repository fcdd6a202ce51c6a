"""NNVSMM by mode trained on what counts: the tracking error of the estimate that all modes share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

from ..checks import Array
from ..models.noise_network import LEAST_NIS, ModeNetwork
from .data import Runs
from .descent import Adam, Kept, clipped
from .mlp import Parameters, as_network, parameters_of


def train_scores_end_to_end(
    variances: Sequence[float],
    training: Runs,
    validation: Runs,
    *,
    start: ModeNetwork,
    best: int | None = None,
    steps: int = 120,
    batch: int = 128,
    rate: float = 0.01,
    patience: int = 60,
    seed: int = 0,
    progress: Callable[[int, float], None] | None = None,
) -> ModeNetwork:
    """The network of constant-velocity modes with these acceleration variances, made better on the tracking error
    itself.

    Gradients through all scans of the filter of :class:`jink.filters.neural_vsmm.NeuralModes`, by autograd. Choosing
    the best few has no derivative, so all modes share the estimate in training; the result keeps the ``best`` (all of
    them by default). Loss, choice and stopping as in :func:`jink.learn.end_to_end.train_end_to_end`.
    """
    rng = np.random.default_rng(seed)
    values = parameters_of(start.network)
    kept: Kept[Parameters] = Kept()
    adam = Adam(rate)
    differentiated: Any = import_module("autograd")
    slope = differentiated.value_and_grad(lambda given, runs: tracking_loss(given, start, variances, runs))
    last = 0
    for step in range(steps):
        some = training.take(rng.choice(len(training), min(batch, len(training)), replace=False))
        _, gradients = slope(values, some)
        now = 0.5 * rate * (1 + np.cos(np.pi * step / steps))
        values = adam.step(values, clipped(gradients), now)
        if step % 5 == 4 or step == steps - 1:
            if kept.offer(float(tracking_loss(values, start, variances, validation)), values):
                last = step
            if progress:
                progress(step, kept.loss)
            if step - last >= patience:
                break
    count = len(variances) if best is None else best
    return replace(start, network=as_network(kept.value), best=count, trained=None)


def tracking_loss(values: Parameters, model: ModeNetwork, variances: Sequence[float], runs: Runs) -> Any:
    """Mean over runs of log(mean squared distance over the scans from the third + R)."""
    anp = _traced()
    squares = _squares(values, model, variances, runs)
    return anp.mean(anp.log(squares / (runs.time.shape[1] - 2) + runs.sd**2))


class _State(NamedTuple):
    """The shared estimate of all runs: p, v (B, 2), and P in blocks position, position by velocity, velocity (B, 2,
    2).
    """

    p: Any
    v: Any
    Pp: Any
    Px: Any
    Pv: Any


def _squares(values: Parameters, model: ModeNetwork, variances: Sequence[float], runs: Runs) -> Any:
    """Squared distances (B,), summed over the scans, of modes that all go on from the combined estimate."""
    anp = _traced()
    z, R, T = runs.z, runs.sd**2, np.diff(runs.time, axis=1)
    noise = np.asarray(variances)[None, :, None, None] * np.eye(2)
    first, P = T[:, 0][:, None, None], R * np.ones((len(z), 1, 1)) * np.eye(2)
    s = _State(z[:, 1], (z[:, 1] - z[:, 0]) / T[:, :1], P, P / first, 2 * P / first**2)
    w = np.full((len(z), len(variances)), 1 / len(variances))
    total = 0.0
    for k in range(2, z.shape[1]):
        t = T[:, k - 1][:, None, None]
        s = _State(
            s.p + t[:, 0] * s.v, s.v, s.Pp + t * (s.Px + anp.swapaxes(s.Px, 1, 2)) + t**2 * s.Pv, s.Px + t * s.Pv, s.Pv
        )
        r = z[:, k] - s.p
        modes = _Modes.of(s, r, noise, t[:, None], R)
        nis = anp.sum(modes.y[..., 0] * r[:, None], axis=2)
        u = anp.concatenate([w, anp.log(nis / 2 + LEAST_NIS)], axis=1)
        w = _shares(values, (u - np.asarray(model.centre)) / np.asarray(model.scale))
        s = modes.combined(s, w[:, :, None, None], R)
        total = total + ((s.p - runs.position[:, k]) ** 2).sum(axis=1)
    return total


class _Modes(NamedTuple):
    """Every mode's P⁻ in blocks, S⁻¹ (B, M, 2, 2), and y = S⁻¹ r (B, M, 2, 1)."""

    Ap: Any
    Ax: Any
    Av: Any
    inverse: Any
    y: Any

    @classmethod
    def of(cls, s: _State, r: Any, noise: Array, t: Array, R: float) -> _Modes:
        """From the shared prediction and residual."""
        Ap, Ax = s.Pp[:, None] + t**4 / 4 * noise, s.Px[:, None] + t**3 / 2 * noise
        inverse = _inverse(Ap + R * np.eye(2))
        y = _traced().matmul(inverse, r[:, None, :, None])
        return cls(Ap, Ax, s.Pv[:, None] + t**2 * noise, inverse, y)

    def combined(self, s: _State, w: Any, R: float) -> _State:
        """The estimate after the update, modes weighed by w (B, M, 1, 1)."""
        anp = _traced()
        Ay = anp.swapaxes(self.Ax, 2, 3)  # velocity by position
        dp, dv = anp.matmul(self.Ap, self.y), anp.matmul(Ay, self.y)
        mp, mv = anp.sum(w * dp, axis=1), anp.sum(w * dv, axis=1)
        ep, ev = dp - mp[:, None], dv - mv[:, None]
        gain, evt = anp.matmul(self.inverse, self.Ax), anp.swapaxes(ev, 2, 3)
        position = R * anp.matmul(self.inverse, self.Ap) + ep * anp.swapaxes(ep, 2, 3)
        velocity = self.Av - anp.matmul(Ay, gain) + ev * evt
        blocks = (anp.sum(w * block, axis=1) for block in (position, R * gain + ep * evt, velocity))
        return _State(s.p + mp[..., 0], s.v + mv[..., 0], *blocks)


def _inverse(S: Any) -> Any:
    """Of symmetric matrices (..., 2, 2)."""
    anp = _traced()
    a, b, d = S[..., 0, 0], S[..., 0, 1], S[..., 1, 1]
    rows = [anp.stack([d, -b], axis=-1), anp.stack([-b, a], axis=-1)]
    return anp.stack(rows, axis=-2) / (a * d - b * b)[..., None, None]


def _shares(values: Parameters, u: Any) -> Any:
    anp = _traced()
    for k in range(0, len(values) - 2, 2):
        u = anp.tanh(u @ values[k].T + values[k + 1])
    scores = u @ values[-2].T + values[-1]
    powers = anp.exp(scores - anp.max(scores, axis=1, keepdims=True))
    return powers / anp.sum(powers, axis=1, keepdims=True)


def _traced() -> Any:
    """NumPy whose operations autograd can follow."""
    return import_module("autograd.numpy")
