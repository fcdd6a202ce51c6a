"""Variable-structure IMM: mode sets that follow the target.

Li & Bar-Shalom, "Multiple-model estimation with variable structure", IEEE T-AC 41(4), 1996; Li, "Hybrid
estimation techniques", Control and Dynamic Systems 76, 1996 (digraph switching, active digraph, adaptive grid).
The recursion: sources are the modes active at k - 1, targets those active at k, the rows of the transition
matrix between them scaled to sum to one; everything else is the IMM.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from oracle.many import Estimates, along, backward_weights, bayes, mixed, predict, update
from oracle.mixture import Mode
from oracle.motion import ConstantVelocity, Motion

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


def neighbours(modes: int, reach: int) -> Mask:
    """Graph (M, M) of modes in a row: adjacent within `reach`, themselves included."""
    place = np.arange(modes)
    return np.abs(place[:, None] - place) <= reach


def graph_transition(graph: Mask, stay: float) -> Array:
    """Stay with this probability; the rest is split equally over the modes adjacent in the graph."""
    others = graph & ~np.eye(len(graph), dtype=bool)
    return stay * np.eye(len(graph)) + (1 - stay) * others / others.sum(axis=1, keepdims=True)


def restricted(Pi: Array, active: Mask) -> Array:
    """Pi (B, M, M) to the active targets only, rows scaled to sum to one; a source from which none of them
    can be reached loses its probability.
    """
    kept = Pi * active[:, None, :]
    total = kept.sum(axis=-1, keepdims=True)
    return np.divide(kept, total, out=np.zeros_like(kept), where=total > 0)


def switched(graph: Mask, Pi: Array, mu: Array) -> Mask:
    """Digraph switching: what is adjacent to the most probable mode of the scan before (the first of equals)."""
    return graph[mu.argmax(axis=-1)]


def most_probable(count: int, Pi: Array, mu: Array) -> Mask:
    """Active digraph: the modes with the largest predicted probabilities over the whole graph, none of which
    is zero (the first of equals).
    """
    c = mu @ Pi
    order = np.argsort(-c, axis=-1, kind="stable")[:, :count]
    active = np.zeros(c.shape, dtype=bool)
    np.put_along_axis(active, order, True, axis=-1)
    return active & (c > 0)


def variable_structure(
    motions: list[Motion],
    time: Array,
    z: Array,
    R: Array,
    Pi: Array,
    mu: Array,
    propose: Callable[[Array, Array], Mask],
) -> Estimates:
    """propose(Pi, mu before) -> active modes (B, M) of this scan; inactive ones have probability zero."""

    def step(modes, mu, k, dt):
        active = propose(Pi, mu)
        c, weights = backward_weights(restricted(Pi, active), mu)
        c = c / c.sum(axis=-1, keepdims=True)
        starts = mixed(motions, modes, weights)
        now = [update(m, predict(m, s, dt), z[:, k], R) for m, s in zip(motions, starts, strict=True)]
        log_likelihood = np.stack([each.log_likelihood for each in now], axis=-1)
        return [each.mode for each in now], bayes(c, log_likelihood)

    return along(motions, time, z, R, mu, step)


def adapted_grid(grid: Array, mu: Array, least: float, bounds, unlikely: float, significant: float) -> Array:
    """Next (B, 3) = left, centre, right of a parameter (Jilkov, Angelova & Semerdjiev, "Design and comparison
    of mode-set adaptive IMM algorithms", IEEE T-AES 35(1), 1999).

    The centre moves to sum mu_i g_i. With dl = max(centre - left, least), dr = max(right - centre, least):
    no jump (centre most probable): a side less probable than `unlikely` comes to half its distance;
    jump to a side (that side most probable): beyond `significant` it goes to twice its distance, and the
    other side keeps its own. Everything stays within `bounds`.
    """
    left, centre, right = grid.T
    dl, dr = np.maximum(centre - left, least), np.maximum(right - centre, least)
    best = mu.argmax(axis=-1)
    middle = (mu * grid).sum(axis=-1)
    scale_left = np.where(best == 1, np.where(mu[:, 0] < unlikely, 0.5, 1.0), 1.0)
    scale_right = np.where(best == 1, np.where(mu[:, 2] < unlikely, 0.5, 1.0), 1.0)
    scale_left = np.where((best == 0) & (mu[:, 0] > significant), 2.0, scale_left)
    scale_right = np.where((best == 2) & (mu[:, 2] > significant), 2.0, scale_right)
    moved = np.stack([middle - scale_left * dl, middle, middle + scale_right * dr], axis=-1)
    return np.clip(moved, *bounds)


def acceleration_grid(
    time: Array,
    z: Array,
    R: Array,
    sd: float,
    Pi: Array,
    mu: Array,
    half_width: float,
    least: float,
    unlikely: float = 0.1,
    significant: float = 0.9,
) -> tuple[Estimates, Array]:
    """Adaptive grid over acceleration levels of one axis: constant-velocity modes with known inputs
    (left, centre, right), begun at -half_width, 0, half_width, which also bounds them. Also the grids (B, N, 3).
    """
    assert z.shape[2] == 1, "one axis"
    motions = [ConstantVelocity(1, acceleration_sd=sd) for _ in range(3)]
    grids = np.tile(np.array([-half_width, 0.0, half_width]), (*z.shape[:2], 1))

    def step(modes: list[Mode], mu, k, dt):
        grids[:, k] = adapted_grid(
            grids[:, k - 1], mu, least, (-half_width, half_width), unlikely, significant
        )
        c, weights = backward_weights(Pi, mu)
        starts = mixed(motions, modes, weights)
        now = [
            update(m, predict(m, s, dt, grids[:, k, j : j + 1]), z[:, k], R)
            for j, (m, s) in enumerate(zip(motions, starts, strict=True))
        ]
        log_likelihood = np.stack([each.log_likelihood for each in now], axis=-1)
        return [each.mode for each in now], bayes(c, log_likelihood)

    return along(motions, time, z, R, mu, step), grids
