"""Process noise from Sugeno rules over the residual and its change (Lee, Joo & Park 2003, equations 13, 14, 19).

rule l: if r is about c1 (spread s1) and dr about c2 (s2), then q = w. q = sum w_l f_l / sum f_l,
f_l = exp(-((r - c1)/s1)^2/2 - ((dr - c2)/s2)^2/2), in logs: far from every centre the nearest rule answers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from oracle.many import (
    Estimates,
    along,
    apply,
    backward_weights,
    bayes,
    measure_matrix,
    mixed,
    predict,
    update,
)
from oracle.motion import ConstantVelocity

Array = NDArray[np.float64]


@dataclass
class Rules:
    """centre (L, 2), spread (L, 2) of r and dr, w (L,) variances."""

    centre: Array
    spread: Array
    w: Array

    @classmethod
    def table(cls, rows, length: float = 1.0, variance: float = 1.0) -> Rules:
        """From a published table (c1 s1 c2 s2 w), with the units its lengths and variances are in."""
        rows = np.asarray(rows, float)
        return cls(rows[:, [0, 2]] * length, rows[:, [1, 3]] * length, rows[:, 4] * variance)

    def q(self, r: Array, dr: Array) -> Array:
        at = np.stack([r, dr], axis=-1)[..., None, :]
        log_firing = -0.5 * (((at - self.centre) / self.spread) ** 2).sum(axis=-1)
        return np.exp(log_firing - logsumexp(log_firing, axis=-1, keepdims=True)) @ self.w


class Carry:
    """A mode's memory per axis: the residual before (NaN: none) and the q used last."""

    def __init__(self, shape, q: float):
        self.residual, self.q = np.full(shape, np.nan), np.full(shape, q)

    def adapt(self, rules: Rules, residual: Array) -> Array:
        """q of this scan. dr is 0 at the first update and after a miss; a miss keeps the last q.

        Reading: a scan that is not complete is a miss to the rules (the update uses what there is).
        """
        missing = np.isnan(residual).any(axis=-1, keepdims=True) | np.zeros(residual.shape, bool)
        r = np.where(missing, 0.0, residual)
        dr = np.where(np.isnan(self.residual), 0.0, r - self.residual)
        self.q = np.where(missing, self.q, rules.q(r, dr))
        self.residual = np.where(missing, np.nan, residual)
        return self.q


def fuzzy_imm(time: Array, z: Array, R: Array, rules: list[Rules], Pi: Array, mu: Array, q_start=None) -> Estimates:
    """IMM of constant-velocity modes with P- = F P F' + G q G', q per axis from that axis' own residual of
    that mode before the update (19-3 to 19-6), so that it belongs to the scan it is used in.

    One set of rules is a fuzzy Kalman filter. q_start: variances used while nothing was measured yet.
    """
    axes = z.shape[2]
    motion = ConstantVelocity(axes, acceleration_sd=0.0)
    motions = [motion] * len(rules)
    q_start = [0.0] * len(rules) if q_start is None else q_start
    carry = [Carry((len(z), axes), q) for q in q_start]

    def step(modes, mu, k, dt):
        c, weights = backward_weights(Pi, mu)
        now = []
        for j, start in enumerate(mixed(motions, modes, weights)):
            residual = z[:, k] - apply(measure_matrix(motion), motion.f(start.x, dt))
            q = carry[j].adapt(rules[j], residual)
            G = motion.input_matrix(dt)
            before = predict(motion, start, dt, noise=G * q[:, None, :] @ G.T)
            now.append(update(motion, before, z[:, k], R))
        return [e.mode for e in now], bayes(c, np.stack([e.log_likelihood for e in now], axis=-1))

    return along(motions, time, z, R, mu, step)
