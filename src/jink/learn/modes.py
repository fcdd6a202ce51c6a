# pyright: reportAttributeAccessIssue=false, reportCallIssue=false
"""NNVSMM by mode: a network that scores the modes, trained on which of them was right, or on the tracking error itself."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..arguments import Array
from ..filters.kalman import Kalman
from ..noise_network import LEAST_NIS, ModeNetwork
from ..sensor import Position
from .aid import UPDATED
from .data import Runs
from .descent import Adam, Kept
from .mlp import Parameters, as_network, fit_network, initial, parameters_of


def train_scores(
    motions: Sequence[Any],
    training: Runs,
    validation: Runs,
    *,
    best: int = 2,
    hidden: int = 16,
    epochs: int = 100,
    seed: int = 0,
) -> ModeNetwork:
    """A network that scores modes of any kind, on labels: how well each mode's own filter knew where the target was.

    The filters run side by side, as the paper's bank does. The wanted share of mode j at a scan is exp(−d²ⱼ/2R) over the sum of
    those, d its distance from the truth; inputs as in :class:`jink.ModeNetwork`, the weights before being the wanted ones.
    Source: Choi, Samal & Ahn 2001, §3 (mode-based design; labels shared out instead of one winner).
    """
    pairs = [_scored(motions, runs) for runs in (training, validation)]
    u = pairs[0][0]
    centre, scale = u.mean(axis=0), np.maximum(u.std(axis=0), 1e-3)
    scaled = [((a - centre) / scale, b) for a, b in pairs]
    network = fit_network(
        *scaled[0], validation=scaled[1], hidden=(hidden,), epochs=epochs, scores=True, seed=seed
    )
    return ModeNetwork(network=network, centre=centre.tolist(), scale=scale.tolist(), best=best)


def _scored(motions: Sequence[Any], runs: Runs) -> tuple[Array, Array]:
    """Inputs (N, 2M) and wanted shares (N, M) at every scan all filters used."""
    sensor = Position(sd=runs.sd, axes=runs.axes)
    distance, fit, used = [], [], np.ones(runs.time.shape, dtype=bool)
    for motion in motions:
        said = Kalman(motion, sensor).filter(**runs.batch(), outputs=("x", "nis", "nis_dof", "status"))
        where = [said.components.index(f"p{axis}") for axis in "xyz"[: runs.axes]]
        error = said.x[:, where].reshape(runs.z.shape) - runs.position
        distance.append((error**2).sum(axis=2))
        with np.errstate(invalid="ignore", divide="ignore"):
            fit.append(np.log(said.nis / said.nis_dof + LEAST_NIS).reshape(runs.time.shape))
        used &= said.status.reshape(runs.time.shape) == UPDATED
    squares = np.where(used, np.stack(distance), 0.0)
    powers = np.exp(-(squares - squares.min(axis=0)) / (2 * runs.sd**2))
    share = np.moveaxis(powers / powers.sum(axis=0), 0, 2)  # (B, S, M)
    before = np.full(share.shape, 1 / len(motions))
    before[:, 1:] = np.where(used[:, :-1, None], share[:, :-1], before[:, 1:])
    u = np.concatenate([before, np.moveaxis(np.stack(fit), 0, 2)], axis=2)
    used &= np.isfinite(runs.position).all(axis=2)
    return u[used], share[used]


def train_scores_end_to_end(
    variances: Sequence[float],
    training: Runs,
    validation: Runs,
    *,
    start: ModeNetwork,
    steps: int = 100,
    batch: int = 128,
    rate: float = 0.01,
    seed: int = 0,
    progress: Callable[[int, float], None] | None = None,
) -> ModeNetwork:
    """The network of constant-velocity modes with these acceleration variances, made better on the tracking error itself.

    Gradients through all scans of the filter of :class:`jink.filters.neural_vsmm.NeuralModes`, in which all modes share the
    estimate (so ``best`` of the result is all of them), by autograd. Loss and choice as in :func:`jink.learn.end_to_end.train_end_to_end`.
    """
    from autograd import value_and_grad

    rng = np.random.default_rng(seed)
    values = parameters_of(start.network)
    kept: Kept[Parameters] = Kept()
    adam = Adam(rate)
    slope = value_and_grad(lambda parameters, runs: _tracking_loss(parameters, start, variances, runs))
    for step in range(steps):
        some = training.take(rng.choice(len(training), min(batch, len(training)), replace=False))
        _, gradients = slope(values, some)
        norm = np.sqrt(sum(float((g * g).sum()) for g in gradients))
        now = 0.5 * rate * (1 + np.cos(np.pi * step / steps))
        values = adam.step(values, [g / max(1.0, norm) for g in gradients], now)
        if step % 5 == 4 or step == steps - 1:
            kept.offer(float(_tracking_loss(values, start, variances, validation)), values)
            if progress:
                progress(step, kept.loss)
    return ModeNetwork(
        network=as_network(kept.value), centre=start.centre, scale=start.scale, best=len(variances)
    )


def _tracking_loss(values: Parameters, model: ModeNetwork, variances: Sequence[float], runs: Runs) -> Any:
    """Mean over runs of log(mean squared distance over the scans from the third + R)."""
    import autograd.numpy as anp

    squares = _squares(values, model, variances, runs)
    return anp.mean(anp.log(squares / (runs.time.shape[1] - 2) + runs.sd**2))


def _squares(values: Parameters, model: ModeNetwork, variances: Sequence[float], runs: Runs) -> Any:
    """Squared distances (B,), summed over the scans, of modes that all go on from the combined estimate."""
    import autograd.numpy as anp

    z, R = runs.z, runs.sd**2
    B, S, _ = z.shape
    eye = np.eye(2)
    noise = np.asarray(variances)[None, :, None, None] * eye
    T = np.diff(runs.time, axis=1)
    first = T[:, 0]
    p, v = z[:, 1], (z[:, 1] - z[:, 0]) / first[:, None]
    # P as blocks over the axes: position, cross and velocity, (B, 2, 2) each
    Pp = R * eye * np.ones((B, 1, 1))
    Px, Pv = Pp / first[:, None, None], 2 * Pp / first[:, None, None] ** 2
    w = np.full((B, len(variances)), 1 / len(variances))
    total = 0.0
    for k in range(2, S):
        t = T[:, k - 1][:, None, None]
        p = p + t[:, 0] * v
        Pp, Px = Pp + t * (Px + anp.swapaxes(Px, 1, 2)) + t**2 * Pv, Px + t * Pv
        r, t = z[:, k] - p, t[:, None]
        Ap, Ax, Av = (
            Pp[:, None] + t**4 / 4 * noise,
            Px[:, None] + t**3 / 2 * noise,
            Pv[:, None] + t**2 * noise,
        )
        inverse = _inverse(Ap + R * eye)
        y = anp.matmul(inverse, r[:, None, :, None])
        nis = anp.sum(y[..., 0] * r[:, None], axis=2)
        u = anp.concatenate([w, anp.log(nis / 2 + LEAST_NIS)], axis=1)
        w = _shares(values, (u - np.asarray(model.centre)) / np.asarray(model.scale))
        weight = w[:, :, None, None]
        Ay = anp.swapaxes(Ax, 2, 3)  # Ax is position by velocity
        dp, dv = anp.matmul(Ap, y), anp.matmul(Ay, y)
        mp, mv = anp.sum(weight * dp, axis=1), anp.sum(weight * dv, axis=1)
        ep, ev = dp - mp[:, None], dv - mv[:, None]
        p, v = p + mp[..., 0], v + mv[..., 0]
        gain = anp.matmul(inverse, Ax)
        et, evt = anp.swapaxes(ep, 2, 3), anp.swapaxes(ev, 2, 3)
        Pp = anp.sum(weight * (R * anp.matmul(inverse, Ap) + ep * et), axis=1)
        Px = anp.sum(weight * (R * gain + ep * evt), axis=1)
        Pv = anp.sum(weight * (Av - anp.matmul(Ay, gain) + ev * evt), axis=1)
        total = total + ((p - runs.position[:, k]) ** 2).sum(axis=1)
    return total


def _inverse(S: Any) -> Any:
    """Of symmetric matrices (..., 2, 2)."""
    import autograd.numpy as anp

    a, b, d = S[..., 0, 0], S[..., 0, 1], S[..., 1, 1]
    rows = [anp.stack([d, -b], axis=-1), anp.stack([-b, a], axis=-1)]
    return anp.stack(rows, axis=-2) / (a * d - b * b)[..., None, None]


def _shares(values: Parameters, u: Any) -> Any:
    import autograd.numpy as anp

    for k in range(0, len(values) - 2, 2):
        u = anp.tanh(u @ values[k].T + values[k + 1])
    scores = u @ values[-2].T + values[-1]
    powers = anp.exp(scores - anp.max(scores, axis=1, keepdims=True))
    return powers / anp.sum(powers, axis=1, keepdims=True)


def untrained(modes: int, *, hidden: int = 16, seed: int = 0) -> ModeNetwork:
    """A network of that many modes to start from, inputs scaled as they usually are."""
    values = initial([2 * modes, hidden, modes], np.random.default_rng(seed))
    return ModeNetwork(
        network=as_network(values), centre=[1 / modes] * modes + [-0.5] * modes, scale=[0.3] * modes + [2.0] * modes, best=modes
    )  # fmt: skip
