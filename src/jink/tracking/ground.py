"""The ground below which no height runs: the lowest one that was measured, less what its error may be.

A target that was seen to land has no estimate below the runway because it was descending when its heights ended. The
estimate that is lifted to the ground keeps its own sd and gains what it was lifted by, so that it claims no more than
before.
"""

from __future__ import annotations

import numpy as np

from ..catalogue.choose import EARTH_RADIUS
from ..filters.row_noise import RowNoise
from ..io.geodesy import SiteFrame
from .placing import Placed
from .state import State

SURE = 3.0  # sds below the lowest height
HEIGHTS = ("altitude", "z")  # components that are heights; an elevation's error grows with the range


def lowest_ground(placed: Placed, noise: RowNoise) -> float:
    """The lowest height (m) that the ground may have, NaN where no height was measured."""
    variance = noise.variance(2) if noise.size > 2 else np.nan
    return float(np.fmin.reduce(least_heights(placed, variance), initial=np.nan))


def least_heights(placed: Placed, variance: np.ndarray | float) -> np.ndarray:
    """What each row says of the ground (N,): its height less what that may err by, NaN where there is none.

    variance (N,), or of all, of the measured heights (m²).
    """
    if placed.axes < 3 or placed.components[2] not in HEIGHTS:
        return np.full(len(placed.height), np.nan)
    return above_earth(placed, placed.plane, placed.height) - SURE * np.sqrt(variance)


def above_earth(placed: Placed, plane: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Heights (N,) of places in the frame; the plane of a radar with altitudes leaves the curved earth."""
    if placed.components[0] != "range":
        return z
    radius = placed.frame.earth_radius if isinstance(placed.frame, SiteFrame) else EARTH_RADIUS
    return z + (plane**2).sum(axis=1) / (2.0 * radius)


def lift(placed: Placed, ground: float | np.ndarray, state: State) -> None:
    """Put the heights below the ground on it, and take the descent from them.

    ground (m), of all rows or of each; NaN: not known.
    """
    if not np.isfinite(ground).any() or "pz" not in state:
        return
    plane = np.stack([state["px"], state["py"]], axis=1)
    depth = ground - above_earth(placed, plane, state["pz"])
    rows = np.flatnonzero(depth > 0.0)
    if not rows.size:
        return
    for name, moved in (("pz", depth[rows]), ("vz", np.maximum(-state["vz"][rows], 0.0))):
        state[name][rows] += moved
        more = np.zeros(depth.size)
        more[rows] = moved**2
        state.widen(name, name, more)
