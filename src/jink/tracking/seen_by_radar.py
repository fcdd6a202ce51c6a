"""Positions x, y of a radar at the origin, whose table has range and azimuth too: their noise is that of these.

The error of a range lies along the line of sight, that of an azimuth across it and grows with the range:
R = u uᵀ sd_r² + v vᵀ (r sd_a)²,  u along, v across.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .placing import Placed
from .scatter import component_sd

MARK = "seen_by_radar"  # column of the rows


def covariances(
    placed: Placed, measured: np.ndarray, starts: np.ndarray, group: np.ndarray, groups: int, given: Mapping[str, float]
) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Covariances (N, 2, 2) in m², and sds of range (m) and azimuth (rad) of each group; None where the rows are no
    radar's, or the data tell too little.

    measured (N,): rows with a position; starts: first rows of parts among them; group (N,) numbers the sources.
    """
    if MARK not in placed.rows.columns or "position" in given or placed.components[:2] != ("x", "y"):
        return None
    x, y = placed.plane.T
    reach, azimuth = np.hypot(x, y), np.arctan2(x, y)
    time = placed.time[measured]
    # angles of neighbouring rows go on across the turn
    along = component_sd(time, reach[measured], starts, group[measured], groups)
    across = component_sd(time, np.unwrap(azimuth[measured]), starts, group[measured], groups)
    along = np.full(groups, given["range"]) if "range" in given else along
    across = np.full(groups, given["azimuth"]) if "azimuth" in given else across
    if not (np.isfinite(along) & np.isfinite(across) & (along > 0) & (across > 0)).all():
        return None
    sight = np.stack([np.sin(azimuth), np.cos(azimuth)], axis=1)
    normal = np.stack([np.cos(azimuth), -np.sin(azimuth)], axis=1)
    length, width = along[group] ** 2, (reach * across[group]) ** 2
    R = sight[:, :, None] * sight[:, None, :] * length[:, None, None]
    return R + normal[:, :, None] * normal[:, None, :] * width[:, None, None], along, across
