"""The near-optimal reference for targets whose axes are turned by an angle that nobody knows.

Accelerations along one axis say nothing of the other, so a turn by 90° changes nothing: the angle is uniform over
90°. For each angle of a grid the plots are turned back and the tree of `near_optimal` runs on both axes. An angle
weighs Π p(z_k | z_0 … z_{k−1}, angle); what is known is the mixture, matched in two moments.
"""

from __future__ import annotations

import math

import numpy as np

from .hypotheses import Array
from .near_optimal import Reference, near_optimal
from .priors import RandomAccelerations


def near_optimal_turned(
    z: Array, prior: RandomAccelerations, *, sd: float, T: float = 1.0, hypotheses: int = 32, angles: int = 16
) -> Reference:
    """As :func:`near_optimal` on z (runs, scans, 2), for axes turned by an unknown angle in each run.

    angles: of the grid over 90°. Errors: those of near_optimal, ValueError unless there are two axes.
    """
    z = np.asarray(z, dtype=float)
    if z.ndim != 3 or z.shape[2] != 2 or angles < 1:
        raise ValueError(f"z and angles: expected (runs, scans, 2) and one angle or more, got {z.shape} and {angles}")
    names: tuple[str, ...] = ()
    means, squares, busy, scores = [], [], [], []
    for angle in (np.arange(angles) + 0.5) * (math.pi / 2 / angles):
        c, s = math.cos(angle), math.sin(angle)
        back = np.array([[c, s], [-s, c]])  # from the plane to the target's axes
        found = near_optimal(z @ back.T, prior, sd=sd, T=T, hypotheses=hypotheses)
        forth = np.kron(back.T, np.eye(3))
        names = found.components
        means.append(found.x @ forth.T)
        squares.append(forth @ found.P @ forth.T)
        busy.append(found.manoeuvring)
        scores.append(np.cumsum(found.log_likelihood_scan, axis=1))
    return _mixture(names, np.stack(means), np.stack(squares), np.stack(busy), np.stack(scores))


def _mixture(names: tuple[str, ...], x: Array, P: Array, busy: Array, score: Array) -> Reference:
    """Of the angles, first axis, by the likelihoods of all plots so far (angles, runs, scans)."""
    total = np.logaddexp.reduce(score, axis=0)
    weight = np.exp(score - total)
    mean = (weight[..., None] * x).sum(axis=0)
    d = x - mean
    spread = (weight[..., None, None] * (P + d[..., :, None] * d[..., None, :])).sum(axis=0)
    apart = mean.reshape(*mean.shape[:2], 2, 3)
    return Reference(
        components=names,
        x=mean,
        P=spread,
        position=apart[..., 0],
        velocity=apart[..., 1],
        acceleration=apart[..., 2],
        manoeuvring=(weight * busy).sum(axis=0),
        log_likelihood_scan=np.diff(total - math.log(len(score)), axis=1, prepend=0.0),
    )
