"""Adaptive IMM (Munir & Atherton, IEE Proc. Radar 142(1), 1995; Lee, Joo & Park 2003, equations 3 to 11).

Constant-velocity modes whose known inputs are levels around an acceleration that a side estimator finds from
the same measurements: x-_j = F x_0j + G (ahat(k-1) + epsilon_j) (7-1), P-_j = F P_0j F' + G q G' (7-2).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from oracle import many
from oracle.many import Estimates, each_axis, joined
from oracle.motion import ConstantVelocity
from oracle.two_stage import augmented, two_stage

Array = NDArray[np.float64]
SIDE = {"two-stage": two_stage, "augmented": augmented}


def levels(intervals) -> Array:
    """0, +e1, -e1, +e2, -e2, ...: the paper's set (3), the estimate itself first."""
    return np.array([0.0] + [sign * e for e in intervals for sign in (1, -1)])


def acceleration(side: str, time, z, R, sd, bias_sd, bias_prior) -> tuple[Array, Array]:
    """The side estimator's ahat(k|k) and the square root of its P_aa(k|k), axis by axis, (B, N, axes)."""
    axes = z.shape[2]
    variances = {float(R[a, a]) for a in range(axes)}
    assert len(variances) == 1, "one noise for all axes"
    found = SIDE[side](time, each_axis(z)[..., 0], variances.pop(), sd, bias_sd, bias_prior)
    return joined(found.x[..., 2:], axes)[..., 0], np.sqrt(joined(found.P[..., 2, 2:], axes)[..., 0])


def adaptive_imm(
    time: Array,
    z: Array,
    R: Array,
    intervals,
    sd: float,
    bias_sd: float,
    bias_prior: float,
    Pi: Array,
    mu: Array,
    side: str = "two-stage",
    in_sd: bool = False,
) -> Estimates:
    """Joint modes: one set of probabilities for all axes, a level being added on every axis.

    lee-2003 runs every axis by itself: give it z of one axis, `many.each_axis(z)`.
    Reading: ahat(k-1) is the side estimator's output after scan k-1; 0 at the start.
    in_sd: intervals in units of the square root of the estimator's P_aa(k-1).
    """
    axes = z.shape[2]
    found = acceleration(side, time, z, R, sd, bias_sd, bias_prior)
    ahat, own = (np.concatenate([np.zeros_like(v[:, :1]), v[:, :-1]], axis=1) for v in found)
    unit = own[:, :, None, :] if in_sd else 1.0
    u = ahat[:, :, None, :] + levels(intervals)[:, None] * unit
    motions = [ConstantVelocity(axes, acceleration_sd=sd) for _ in levels(intervals)]
    return many.imm(motions, time, z, R, Pi, mu, u)
