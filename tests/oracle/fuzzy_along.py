"""Fuzzy process noise along and across the velocity: rules over the residual in the frame of the track.

v is the velocity predicted by the mode, P_v its covariance without the noise of the step, e = v / sqrt(v'v + tr P_v).
The residual r = along e + across w, w of length one; the change d of the residual vector reaches d'e along e and d'w
along w. q_along = rules(along, d'e), q_across = others(across, d'w), and the acceleration has the covariance
D = q_across I + (q_along - q_across) e e', so that Q = G D G'. w has no side: left is as right.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from oracle.fuzzy import Rules
from oracle.many import Estimates, along, apply, backward_weights, bayes, measure_matrix, mixed, predict, update
from oracle.motion import ConstantVelocity

Array = NDArray[np.float64]


class TrackCarry:
    """What a mode of one track remembers: the residual vector before (None: none), and the last two variances."""

    def __init__(self, q: float):
        self.residual, self.q = None, (q, q)

    def spread(self, rules: tuple[Rules, Rules], v: Array, P_v: Array, r: Array) -> Array:
        """D of this scan. A scan that is not complete is a miss: it keeps the variances and ends the change."""
        e = v / np.sqrt(v @ v + np.trace(P_v))
        if np.isnan(r).any():
            self.residual = None
        else:
            change = np.zeros_like(r) if self.residual is None else r - self.residual
            self.residual = r
            rest = r - (r @ e) * e
            w = rest / np.linalg.norm(rest)
            self.q = (float(rules[0].q(r @ e, change @ e)), float(rules[1].q(rest @ w, change @ w)))
        return self.q[1] * np.eye(len(v)) + (self.q[0] - self.q[1]) * np.outer(e, e)


def fuzzy_imm_along_track(
    time: Array, z: Array, R: Array, rules: list[tuple[Rules, Rules]], Pi: Array, mu: Array, q_start: list[float]
) -> Estimates:
    """IMM of constant velocities, each with rules along its velocity and rules across it; one set: a Kalman filter."""
    B, _, axes = z.shape
    motion = ConstantVelocity(axes, acceleration_sd=0.0)
    motions = [motion] * len(rules)
    carry = [[TrackCarry(q) for _ in range(B)] for q in q_start]

    def step(modes, mu, k, dt):
        c, weights = backward_weights(Pi, mu)
        G = motion.input_matrix(dt)
        now = []
        for j, start in enumerate(mixed(motions, modes, weights)):
            bare = predict(motion, start, dt)
            residual = z[:, k] - apply(measure_matrix(motion), bare.x)
            D = [carry[j][b].spread(rules[j], bare.x[b, 1::2], bare.P[b, 1::2, 1::2], residual[b]) for b in range(B)]
            before = predict(motion, start, dt, noise=G @ np.array(D) @ G.T)
            now.append(update(motion, before, z[:, k], R))
        return [e.mode for e in now], bayes(c, np.stack([e.log_likelihood for e in now], axis=-1))

    return along(motions, time, z, R, mu, step)
