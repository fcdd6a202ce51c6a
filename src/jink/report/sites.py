"""Where radars stand on the plan view, and how far they see."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from .plan import plan_point


def site_places(
    summary: Mapping[str, Any], frame: dict[str, float] | None, east: np.ndarray, north: np.ndarray
) -> list[dict[str, float | str]]:
    """{"name", "x", "y", "range"} of each radar in the plan's metres; range: of the farthest row.

    A table of ranges and azimuths without a site has its radar at the origin.
    """
    given = summary.get("sites") or {}
    if frame is None:
        polar = "range" in (summary.get("columns") or {})
        points = {"": (0.0, 0.0)} if polar or given else {}
    else:
        points = {str(name): plan_point(frame, *place[:2]) for name, place in given.items()}
    found = []
    for name, (x, y) in points.items():
        distance = np.hypot(east - x, north - y)
        if np.isfinite(distance).any():
            found.append({"name": name, "x": x, "y": y, "range": float(np.nanmax(distance))})
    return found
