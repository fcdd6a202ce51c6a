"""Variable-structure IMM: mode sets that follow the target.

Li & Bar-Shalom, "Multiple-model estimation with variable structure", IEEE T-AC 41(4), 1996; Li, "Hybrid
estimation techniques", Control and Dynamic Systems 76, 1996 (digraph switching, active digraph, adaptive grid).
The recursion: sources are the modes active at k - 1, targets those active at k, with a transition matrix between
them; everything else is the IMM.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from oracle.many import Estimates, along, backward_weights, mixed, scanned
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


def one_change(G: Array) -> Callable[[float], Array]:
    """The chain of generator G over dt, taken to change once at most: stay exp(G_ii dt), the rest as from G."""

    def over(dt: float) -> Array:
        stay = np.exp(np.diag(G) * dt)
        others = G - np.diag(np.diag(G))
        return np.diag(stay) + (1 - stay)[:, None] * others / others.sum(axis=1, keepdims=True)

    return over


def restricted(Pi: Array, active: Mask) -> Array:
    """Pi (M, M) between active targets only, (B, M, M).

    Reading. A mode that stays active stays with its own probability; the rest goes to the active modes it may
    change to, in proportion. One that is no longer active leaves all it has to those, or, where there are none,
    to all active modes alike.
    """
    own = np.eye(len(Pi), dtype=bool)
    others = np.where(own, 0.0, Pi) * active[:, None, :]
    total = others.sum(axis=-1, keepdims=True)
    stay = np.where(total > 0, np.diag(Pi)[:, None], 1.0) * active[:, :, None]
    alike = active[:, None, :] / active.sum(axis=-1)[:, None, None]
    spread = np.divide(others, total, out=np.zeros_like(others), where=total > 0)
    return np.where(own, stay, (1 - stay) * spread) + np.where((stay == 0) & (total == 0), alike, 0.0)


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
    Pi: Array | Callable[[float], Array],
    mu: Array,
    propose: Callable[[Array, Array], Mask],
) -> Estimates:
    """propose(Pi, mu before) -> active modes (B, M) of this scan; inactive ones have probability zero.

    Pi of each scan, or as a function of the time since the scan before.
    """

    def step(modes, mu, k, dt):
        now_Pi = Pi(dt) if callable(Pi) else Pi
        active = propose(now_Pi, mu)
        c, weights = backward_weights(restricted(now_Pi, active), mu)
        c = c / c.sum(axis=-1, keepdims=True)
        return scanned(motions, mixed(motions, modes, weights), c, z[:, k], R, dt)

    return along(motions, time, z, R, mu, step)


def adapted_grid(grid: Array, mu: Array, least: float, bounds, unlikely: float, likely: float) -> Array:
    """Next (B, 3) = left, centre, right of a parameter (Jilkov, Angelova & Semerdjiev, "Design and comparison
    of mode-set adaptive IMM algorithms", IEEE T-AES 35(1), 1999).

    The centre moves to sum mu_i g_i. A side less probable than `unlikely` comes to half its distance from the
    centre; one more probable than `likely` (the target has jumped) goes out to twice it; none comes nearer than
    `least`. The centre keeps `least` from the bounds, the sides stay within them. Reading: the paper asks for
    the most probable of the three first, which thresholds below and above one half decide as well.
    """
    left, centre, right = grid.T

    def distance(before, mine):
        return np.maximum(before * np.where(mine < unlikely, 0.5, np.where(mine > likely, 2.0, 1.0)), least)

    low, high = bounds
    middle = np.clip((mu * grid).sum(axis=-1), low + least, high - least)
    to_left, to_right = distance(centre - left, mu[:, 0]), distance(right - centre, mu[:, 2])
    return np.stack([np.maximum(middle - to_left, low), middle, np.minimum(middle + to_right, high)], axis=-1)


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
    likely: float = 0.9,
) -> tuple[Estimates, Array]:
    """Adaptive grid over acceleration levels of one axis: constant-velocity modes with known inputs
    (left, centre, right), begun at -half_width, 0, half_width, which also bounds them. Also the grids (B, N, 3).
    """
    assert z.shape[2] == 1, "one axis"
    motions = [ConstantVelocity(1, acceleration_sd=sd) for _ in range(3)]
    grids = np.tile(np.array([-half_width, 0.0, half_width]), (*z.shape[:2], 1))

    def step(modes: list[Mode], mu, k, dt):
        grids[:, k] = adapted_grid(grids[:, k - 1], mu, least, (-half_width, half_width), unlikely, likely)
        c, weights = backward_weights(Pi, mu)
        inputs = [grids[:, k, j : j + 1] for j in range(3)]
        return scanned(motions, mixed(motions, modes, weights), c, z[:, k], R, dt, inputs)

    return along(motions, time, z, R, mu, step), grids
