"""Mixing and combining modes of different state dimensions.

A component that the target mode has and the source lacks enters with mean 0 and the target mode's prior
variance, independent of the rest (mixing="prior"), or with the target mode's own mean and variance block,
uncorrelated (mixing="unbiased": Yuan, Bar-Shalom, Willett, Carson, "Unbiased IMM", IEEE T-AES 48(1), 2012).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oracle.motion import AXES, KnownTurn, Motion

Array = NDArray[np.float64]

SLOWEST = 1e-3  # m/s: what moves slower turns, for its reported turn rate, as if it moved at this speed


@dataclass
class Mode:
    x: Array
    P: Array


def selection(source: Motion, target: Motion) -> Array:
    """A (n_target, n_source): copies the components both have, and leaves zero rows for those the source
    lacks.
    """
    A = np.zeros((target.n, source.n))
    for row, name in enumerate(target.components):
        if name in source.components:
            A[row, source.index(name)] = 1
    return A


def entering(source: Motion, target: Motion, own: Mode, mixing: str) -> tuple[Array, Array]:
    """Mean and covariance (zero elsewhere) of the target's components that the source lacks."""
    x, P = np.zeros(target.n), np.zeros((target.n, target.n))
    lacking = [i for i, name in enumerate(target.components) if name not in source.components]
    if mixing == "unbiased":
        x[lacking] = own.x[lacking]
        P[np.ix_(lacking, lacking)] = own.P[np.ix_(lacking, lacking)]
    else:
        for i in lacking:
            P[i, i] = target.prior_variance(target.components[i])
    return x, P


def augment(source: Motion, mode: Mode, target: Motion, own: Mode, mixing: str) -> Mode:
    """The source mode's estimate in the target mode's coordinates."""
    A = selection(source, target)
    x, P = entering(source, target, own, mixing)
    return Mode(A @ mode.x + x, A @ mode.P @ A.T + P)


def match(weights, modes: list[Mode]) -> Mode:
    """Mean and covariance of a Gaussian mixture."""
    x = sum(w * m.x for w, m in zip(weights, modes, strict=True))
    P = sum(w * (m.P + np.outer(m.x - x, m.x - x)) for w, m in zip(weights, modes, strict=True))
    return Mode(x, P)


def mix(motions: list[Motion], modes: list[Mode], mu: Array, Pi: Array, mixing: str) -> tuple[Array, list[Mode]]:
    """Predicted mode probabilities c = Pi' mu and each mode's mixed start, weights Pi_ij mu_i / c_j."""
    c = Pi.T @ mu
    mixed = []
    for j, target in enumerate(motions):
        if c[j] <= 0:  # nothing can have come here
            mixed.append(modes[j])
            continue
        sources = [augment(motions[i], modes[i], target, modes[j], mixing) for i in range(len(motions))]
        mixed.append(match(Pi[:, j] * mu / c[j], sources))
    return c, mixed


def union(motions: list[Motion]) -> tuple[str, ...]:
    """All components, interleaved per axis, turn_rate last."""
    have = {name for m in motions for name in m.components}
    ordered = [letter + a for a in AXES for letter in "pva"] + ["turn_rate"]
    return tuple(name for name in ordered if name in have)


def lift(motion: Motion, mode: Mode, components: tuple[str, ...]) -> Mode:
    """The mode in the union's components: what it lacks by kinematics, covariance through that map's
    Jacobian.
    """
    x, index = mode.x, motion.index
    value, J = np.zeros(len(components)), np.zeros((len(components), motion.n))
    for row, name in enumerate(components):
        if name in motion.components:
            value[row] = x[index(name)]
            J[row, index(name)] = 1
        elif name == "turn_rate" and isinstance(motion, KnownTurn):
            value[row] = motion.turn_rate
        elif name == "turn_rate" and "ax" in motion.components and motion.axes >= 2:
            vx, vy, ax, ay = (x[index(c)] for c in ("vx", "vy", "ax", "ay"))
            v2 = max(vx**2 + vy**2, SLOWEST**2)
            w = value[row] = (vx * ay - vy * ax) / v2
            for c, d in (("vx", ay - 2 * vx * w), ("vy", -ax - 2 * vy * w), ("ax", -vy), ("ay", vx)):
                J[row, index(c)] = d / v2
        elif name in ("ax", "ay") and (motion.turning or isinstance(motion, KnownTurn)):
            across, sign = ("vy", -1.0) if name == "ax" else ("vx", 1.0)  # w x v = (-w vy, w vx)
            w = x[index("turn_rate")] if motion.turning else motion.turn_rate
            value[row] = sign * w * x[index(across)]
            J[row, index(across)] = sign * w
            if motion.turning:
                J[row, index("turn_rate")] = sign * x[index(across)]
    return Mode(value, J @ mode.P @ J.T)


def combine(motions: list[Motion], modes: list[Mode], mu: Array) -> Mode:
    """The moment-matched estimate over the union of the components."""
    components = union(motions)
    return match(mu, [lift(m, mode, components) for m, mode in zip(motions, modes, strict=True)])
