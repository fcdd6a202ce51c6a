"""NNVSMM by mode: a network that scores the modes, trained on which of them was right."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..checks import Array
from ..estimate import Status
from ..filters.kalman import Kalman
from ..models.noise_network import LEAST_NIS, ModeNetwork
from ..models.sensor import Position
from .data import Runs
from .mlp import as_network, fit_network, initial


def train_scores(
    motions: Sequence[Any],
    training: Runs,
    validation: Runs,
    *,
    best: int = 3,
    hidden: int = 16,
    epochs: int = 100,
    seed: int = 0,
) -> ModeNetwork:
    """A network that scores modes of any kind, on labels: how well each mode's own filter knew where the target was.

    The filters run side by side, as the paper's bank does. The wanted share of mode j at a scan is exp(−d²ⱼ/2R) over
    the sum of those, d its distance from the truth; inputs as in :class:`jink.models.noise_network.ModeNetwork`, the
    weights before being the wanted ones. Source: Choi, Samal & Ahn 2001, §3 (mode-based design; labels shared out
    instead of one winner).
    """
    pairs = [_scored(motions, runs) for runs in (training, validation)]
    u = pairs[0][0]
    centre, scale = u.mean(axis=0), np.maximum(u.std(axis=0), 1e-3)
    scaled = [((a - centre) / scale, b) for a, b in pairs]
    network = fit_network(*scaled[0], validation=scaled[1], hidden=(hidden,), epochs=epochs, scores=True, seed=seed)
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
        used &= said.status.reshape(runs.time.shape) == Status.updated
    squares = np.where(used, np.stack(distance), 0.0)
    powers = np.exp(-(squares - squares.min(axis=0)) / (2 * runs.sd**2))
    share = np.moveaxis(powers / powers.sum(axis=0), 0, 2)  # (B, S, M)
    before = np.full(share.shape, 1 / len(motions))
    before[:, 1:] = np.where(used[:, :-1, None], share[:, :-1], before[:, 1:])
    u = np.concatenate([before, np.moveaxis(np.stack(fit), 0, 2)], axis=2)
    used &= np.isfinite(runs.position).all(axis=2)
    return u[used], share[used]


def untrained(modes: int, *, hidden: int = 16, seed: int = 0) -> ModeNetwork:
    """A network of that many modes to start from, inputs scaled as they usually are."""
    values = initial([2 * modes, hidden, modes], np.random.default_rng(seed))
    return ModeNetwork(
        network=as_network(values),
        centre=[1 / modes] * modes + [-0.5] * modes,
        scale=[0.3] * modes + [2.0] * modes,
        best=modes,
    )
