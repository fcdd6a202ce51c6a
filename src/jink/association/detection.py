"""How often a sensor sees what is there, as its own tracks have shown."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..models.radar import Radar
from .picture import Picture

WEIGHT = 30.0  # of the declared probability, in scans of one track
MEMORY = 3000.0  # track-scans; older ones count less
OLD = 5  # scans from which a track counts: those that have just been confirmed all had a plot


@dataclass
class Detections:
    """Hits of tracks that are surely there, and their scans."""

    hits: float = 0.0
    scans: float = 0.0

    def take(self, radar: Radar, picture: Picture) -> None:
        """Add one scan of this radar: confirmed tracks where it looks, with a plot or without."""
        if not len(picture):
            return
        points = picture.positions
        (x0, x1, y0, y1), (x, y, reach) = radar.limits()
        px, py = points[:, 0], points[:, 1] if points.shape[1] > 1 else np.zeros(len(points))
        looked = picture.due | (picture.plot >= 0)
        sure = looked & picture.confirmed & (picture.age >= OLD) & (px >= x0) & (px <= x1)
        if points.shape[1] > 1:
            sure &= (py >= y0) & (py <= y1) & ((px - x) ** 2 + (py - y) ** 2 <= reach**2)
        kept = min(1.0, MEMORY / max(self.scans, 1.0))
        self.hits = kept * self.hits + float((sure & (picture.plot >= 0)).sum())
        self.scans = kept * self.scans + float(sure.sum())

    def probability(self, declared: float) -> float:
        """p = (w p₀ + hits)/(w + scans), the mean of a beta distribution; between 0.05 and 0.99."""
        p = (WEIGHT * declared + self.hits) / (WEIGHT + self.scans)
        return min(max(p, 0.05), max(declared, 0.99))
