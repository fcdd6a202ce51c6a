"""Networks that choose the motion model (Choi, Samal & Ahn 2001): process noise by parameter, or scores by mode.

Constant velocity on axes that share one process noise, Q = q G G' per axis; tracks (B,).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from oracle.many import Estimates, along, match, measure_matrix, predict, update
from oracle.motion import ConstantVelocity

Array = NDArray[np.float64]
Network = Callable[[Array], Array]


def published_inputs(q: Array, residual: Array, variance: Array) -> Array:
    """(q, N(r_i; 0, S_ii) of each axis)."""
    likelihood = np.exp(-(residual**2) / variance / 2) / np.sqrt(2 * np.pi * variance)
    return np.column_stack([q, likelihood])


def log_inputs(q: Array, residual: Array, variance: Array) -> Array:
    """(log q, log(r_i^2/S_ii + 0.01) of each axis)."""
    return np.column_stack([np.log(q), np.log(residual**2 / variance + 0.01)])


def by_parameter(
    network: Network, time: Array, z: Array, R: Array, q_start: float, inputs=published_inputs
) -> Estimates:
    """One filter. With P- of the last q: what the network sees; with P- of the q it answers: the update.

    Readings. "The Kalman filter whose estimation error is smallest" would need the truth: the filter with the
    last q stands for it. The output is the noise "for current estimation", so the residual that asks for it is
    used with it. A scan that is not complete keeps the last q.
    """
    axes = z.shape[2]
    motion = ConstantVelocity(axes, acceleration_sd=0.0)
    H = measure_matrix(motion)
    q = np.full(len(z), float(q_start))

    def noise(q, dt):
        G = motion.input_matrix(dt)
        return q[:, None, None] * (G @ G.T)

    def step(modes, mu, k, dt):
        nonlocal q
        complete = ~np.isnan(z[:, k]).any(axis=-1)
        last = predict(motion, modes[0], dt, noise=noise(q, dt))
        residual = np.where(complete[:, None], z[:, k] - last.x @ H.T, 0.0)
        S = H @ last.P @ H.T + R
        q = np.where(complete, network(inputs(q, residual, np.diagonal(S, axis1=1, axis2=2))), q)
        before = predict(motion, modes[0], dt, noise=noise(q, dt))
        return [update(motion, before, z[:, k], R).mode], mu

    return along([motion], time, z, R, np.ones(1), step)


def best_of(scores: Array, best: int) -> Array:
    """Softmax of the `best` highest scores, zero for the others (the first of equals)."""
    order = np.argsort(-scores, axis=-1, kind="stable")[:, :best]
    chosen = np.zeros(scores.shape, dtype=bool)
    np.put_along_axis(chosen, order, True, axis=-1)
    weight = np.where(chosen, np.exp(scores - scores.max(axis=-1, keepdims=True)), 0.0)
    return weight / weight.sum(axis=-1, keepdims=True)


def by_mode(network: Network, time: Array, z: Array, R: Array, variances, best: int) -> Estimates:
    """x = sum w_j x_j over the `best` modes by the network's scores (equation 8), which sees the weights of the
    scan before and every mode's log(NIS/axes + 0.01).

    Readings. Every mode goes on from the combined estimate, or sluggish modes would be lost for good after one
    manoeuvre. Weights begin equal; a scan that is not complete keeps them.
    """
    axes = z.shape[2]
    M = len(variances)
    motions = [ConstantVelocity(axes, acceleration_sd=np.sqrt(q)) for q in variances]

    def step(modes, mu, k, dt):
        start = match(mu, modes)
        now = [update(m, predict(m, start, dt), z[:, k], R) for m in motions]
        complete = ~np.isnan(z[:, k]).any(axis=-1)
        nis = np.stack([np.einsum("bi,bij,bj->b", e.residual, np.linalg.inv(e.S), e.residual) for e in now], axis=-1)
        scores = network(np.concatenate([mu, np.log(nis / axes + 0.01)], axis=1))
        return [e.mode for e in now], np.where(complete[:, None], best_of(scores, best), mu)

    return along(motions, time, z, R, np.full(M, 1 / M), step)
