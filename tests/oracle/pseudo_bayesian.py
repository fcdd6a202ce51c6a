"""Generalised pseudo-Bayesian estimators of first and second order, and the static multiple-model estimator.

Bar-Shalom, Li & Kirubarajan 2001, sections 11.6.2 (static), 11.6.4 (GPB1) and 11.6.5 (GPB2); Tugnait,
"Detection and estimation for abruptly changing systems", Automatica 18(5), 1982.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from oracle.many import (
    Estimates,
    along,
    augment,
    backward_weights,
    bayes,
    match,
    mixed,
    predict,
    scanned,
    update,
)
from oracle.motion import Motion

Array = NDArray[np.float64]


def gpb1(motions: list[Motion], time: Array, z: Array, R: Array, Pi: Array, mu: Array) -> Estimates:
    """Every mode starts from the one combined estimate; mu_j ~ L_j sum_i Pi_ij mu_i.

    With components that not all modes have, the combined estimate is formed in the target's components.
    """

    def step(modes, mu, k, dt):
        M = len(motions)
        same = np.broadcast_to(mu[:, :, None], (len(mu), M, M))
        return scanned(motions, mixed(motions, modes, same), mu @ Pi, z[:, k], R, dt)

    return along(motions, time, z, R, mu, step)


def gpb2(motions: list[Motion], time: Array, z: Array, R: Array, Pi: Array, mu: Array) -> Estimates:
    """A filter per pair: from mode i before under mode j now; mu_ij ~ L_ij Pi_ij mu_i, merged over i."""

    def step(modes, mu, k, dt):
        B, M = mu.shape
        log_likelihood, after = np.empty((B, M, M)), []
        for j, target in enumerate(motions):
            pairs = [augment(motions[i], modes[i], target) for i in range(M)]
            now = [update(target, predict(target, pair, dt), z[:, k], R) for pair in pairs]
            after.append([each.mode for each in now])
            log_likelihood[:, :, j] = np.stack([each.log_likelihood for each in now], axis=-1)
        prior = Pi * mu[:, :, None]
        joint = bayes(prior.reshape(B, -1), log_likelihood.reshape(B, -1)).reshape(B, M, M)
        _, weights = backward_weights(joint, np.ones((B, M)))
        return [match(weights[:, :, j], after[j]) for j in range(M)], joint.sum(axis=1)

    return along(motions, time, z, R, mu, step)


def static(motions: list[Motion], time: Array, z: Array, R: Array, mu: Array) -> Estimates:
    """MMAE: filters that never meet; mu_j ~ L_j mu_j (Magill 1965)."""

    def step(modes, mu, k, dt):
        return scanned(motions, modes, mu, z[:, k], R, dt)

    return along(motions, time, z, R, mu, step)
