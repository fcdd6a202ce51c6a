"""How often a sensor sees what is there, as its own tracks have shown."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

WEIGHT = 10.0  # of the declared probability once it is contradicted, in scans of one track
MEMORY = 3000.0  # track-scans; older ones count less
STRAY = 0.1  # share of tracks by which one scan may differ from what is believed; an outage says nothing of others
DOUBT = 3.0  # standard errors that what was seen must lie off, before what was declared is corrected


@dataclass
class Detections:
    """Hits of tracks that were surely there before the scan, and their scans.

    A track counts by what is known before the scan, so that its own hit or miss does not choose it.
    """

    hits: float = 0.0
    scans: float = 0.0

    def take(self, report: dict[str, Any], declared: float) -> None:
        """Add one scan: of tracks that existed with more than 0.95 and have five plots, those that were looked at."""
        sure = report["sure"]
        expected, far = sure * self.mean(declared), STRAY * sure + 2.0
        kept = min(1.0, MEMORY / max(self.scans, 1.0))
        self.hits = kept * self.hits + min(max(report["seen"], expected - far), expected + far)
        self.scans = kept * self.scans + sure

    def mean(self, declared: float) -> float:
        """(w p₀ + hits)/(w + n), the mean of a beta distribution."""
        return (WEIGHT * declared + self.hits) / (WEIGHT + self.scans)

    def probability(self, declared: float) -> float:
        """What was declared, p₀, unless |hits − n p₀| > 1 + 3 √(n p₀ (1 − p₀)); then the mean, within 0.05 to 0.99."""
        n = self.scans
        if not abs(self.hits - n * declared) > 1.0 + DOUBT * math.sqrt(n * declared * (1.0 - declared)):
            return declared
        return min(max(self.mean(declared), 0.05), max(declared, 0.99))
