"""Whether ranges of a radar without heights are slant ranges of targets high above it.

A target at height h that flies straight is seen at r² = h² + g², g along the ground. Taken for ranges along the ground,
its path bends away from the radar. The height that makes windows of the path straight is looked for.
"""

from __future__ import annotations

import numpy as np

WINDOW = 24  # rows
HEIGHTS = np.arange(500.0, 15_001.0, 250.0)
STEEP = 0.25  # of height over the least range of a window, below which nothing shows
BENT = 6.0  # times the mean square of what remains of a straight path, as against that at the height
WINDOWS = 2
ROWS = 2000  # of a part that are looked at


def slant_height(time: np.ndarray, plane: np.ndarray) -> float:
    """The height (m) at which one target's paths are straight, NaN where they are so at none or at all.

    time (N,) s, plane (N, 2) m east and north of the radar.
    """
    found = []
    for begin in range(0, min(time.size, ROWS) - WINDOW + 1, WINDOW // 2):
        some = slice(begin, begin + WINDOW)
        height = _of_window(time[some], plane[some])
        if np.isfinite(height):
            found.append(height)
    return float(np.median(found)) if len(found) >= WINDOWS else np.nan


def _of_window(time: np.ndarray, plane: np.ndarray) -> float:
    far = np.hypot(plane[:, 0], plane[:, 1])
    elapsed = time - time.mean()
    if not elapsed.any() or not np.isfinite(far).all():
        return np.nan
    heights = HEIGHTS[(0.98 * far.min() > HEIGHTS) & (STEEP * far.min() < HEIGHTS)]
    if not heights.size:
        return np.nan
    ground = np.sqrt(far**2 - np.r_[0.0, heights][:, None] ** 2) / far
    left = np.zeros(ground.shape[0])
    for axis in range(2):
        path = ground * plane[:, axis]
        path = path - path.mean(axis=1, keepdims=True)
        slope = path @ elapsed / (elapsed @ elapsed)
        left += ((path - slope[:, None] * elapsed) ** 2).mean(axis=1)
    best = int(np.argmin(left[1:])) + 1
    inside = 1 < best < heights.size or heights.size < 3
    return float(heights[best - 1]) if inside and left[0] > BENT * left[best] else np.nan
