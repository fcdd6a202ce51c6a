"""Starting a mode's state from one or two position fixes (Bar-Shalom 2001, 5.5.3), independent priors for the
rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oracle.gaussian import parts
from oracle.mixture import Mode
from oracle.motion import Motion

Array = NDArray[np.float64]


@dataclass
class OnePoint:
    velocity_sd: float


@dataclass
class TwoPoint:
    velocity_sd: float
    bounded: bool = False


@dataclass
class Prior:
    """Each mode's own state at the first row's time, before its update."""

    modes: list[Mode]


@dataclass
class Fix:
    """A complete position, and the velocity where the sensor measures that too."""

    time: float
    position: Array
    R: Array
    velocity: Array | None = None
    R_velocity: Array | None = None


def priors(motion: Motion) -> list[int]:
    """The components that no position fix tells anything about."""
    return [i for i, name in enumerate(motion.components) if name[0] not in "pv"]


def one_point(motion: Motion, fix: Fix, velocity_sd: float) -> Mode:
    """Position z with R, velocity as measured or 0 with velocity_sd^2, the rest 0 with prior variances."""
    position, velocity = parts(motion)
    x, P = np.zeros(motion.n), np.zeros((motion.n, motion.n))
    x[position] = fix.position
    P[np.ix_(position, position)] = fix.R
    if fix.velocity is None:
        P[velocity, velocity] = velocity_sd**2
    else:
        x[velocity] = fix.velocity
        P[np.ix_(velocity, velocity)] = fix.R_velocity
    for i in priors(motion):
        P[i, i] = motion.prior_variance(motion.components[i])
    return Mode(x, P)


def contradicted(first: Fix, second: Fix, velocity_sd: float) -> bool:
    """Whether a target of such a speed cannot have come from the first position to the second: 5 sds in all axes."""
    moved = second.position - first.position
    variance = np.diag(first.R + second.R) + (velocity_sd * (second.time - first.time)) ** 2
    return bool((moved**2 / variance).sum() > 25.0)


def slowed(motion: Motion, mode: Mode, velocity_sd: float) -> Mode:
    """The mode given that its velocity is from N(0, velocity_sd^2) per axis: Bayes, by a measured velocity of zero."""
    _, velocity = parts(motion)
    H = np.eye(motion.n)[velocity]
    gain = mode.P @ H.T @ np.linalg.inv(H @ mode.P @ H.T + velocity_sd**2 * np.eye(len(H)))
    return Mode(mode.x - gain @ H @ mode.x, mode.P - gain @ H @ mode.P)


def two_point(motion: Motion, first: Fix, second: Fix) -> Mode:
    """Position z2, velocity (z2 - z1)/T, their covariance by propagating the errors of z1, z2 and of the
    acceleration.

    With n1, n2 the noises and a the acceleration: p = z2 - n2, v = (z2 - z1)/T - (n2 - n1)/T + a T/2.
    """
    T, axes = second.time - first.time, motion.axes
    position, velocity = parts(motion)
    rest = priors(motion)
    x = np.zeros(motion.n)
    x[position] = second.position
    x[velocity] = (second.position - first.position) / T
    cause = np.zeros((2 * axes + len(rest), 2 * axes + len(rest)))  # covariance of n1, n2 and the rest
    cause[:axes, :axes], cause[axes : 2 * axes, axes : 2 * axes] = first.R, second.R
    effect = np.zeros((motion.n, len(cause)))
    for a in range(axes):
        effect[position[a], axes + a] = 1
        effect[velocity[a], a], effect[velocity[a], axes + a] = -1 / T, 1 / T
    for column, i in enumerate(rest, start=2 * axes):
        name = motion.components[i]
        cause[column, column] = motion.prior_variance(name)
        effect[i, column] = 1
        if name[0] == "a":
            effect[motion.index("v" + name[1]), column] = T / 2
    return Mode(x, effect @ cause @ effect.T)
