"""How large the area is that a sensor looks at, as far as its plots have shown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..checks import Array
from ..models.radar import Radar

LEAST = 200.0  # noise sds along a side, where few plots say little


@dataclass
class Extent:
    """The box that holds the plots so far; five numbers, so that it can be saved."""

    low: list[float] = field(default_factory=lambda: [np.inf, np.inf])
    high: list[float] = field(default_factory=lambda: [-np.inf, -np.inf])
    count: float = 0.0

    def take(self, points: Array) -> None:
        """Add plots (n, 2 or more axes)."""
        if len(points):
            self.low = [min(a, float(b)) for a, b in zip(self.low, points.min(axis=0), strict=False)]
            self.high = [max(a, float(b)) for a, b in zip(self.high, points.max(axis=0), strict=False)]
            self.count += len(points)

    def area(self, radar: Radar, others: Sequence[Radar], sd: float) -> float:
        """The declared area, or else that of the plots' box.

        It is at least as large as that of other radars and as the noise makes likely.

        n points uniform on a side span (n − 1)/(n + 1) of it.
        """
        declared = radar.size()
        if declared is not None:
            return declared
        n = max(self.count, 2.0)
        side = np.maximum(np.subtract(self.high, self.low) * (n + 1) / (n - 1), LEAST * sd)
        return max(float(side.prod()), *(other.size() or 0.0 for other in others), 0.0)

    @property
    def numbers(self) -> list[float]:
        """The box as numbers, for saving."""
        return [*self.low, *self.high, self.count]

    @classmethod
    def of(cls, numbers: Sequence[float]) -> Extent:
        """The box of saved numbers."""
        a, b, c, d, n = (float(v) for v in numbers)
        return cls([a, b], [c, d], n)
