"""Where tracks were some scans ago, by all that came since: each track's most probable plots, filtered with a lag."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..checks import Array
from ..estimate import Estimate
from .picture import Picture

OUTPUTS = ("x", "P", "mode_probability")


class Laggards:
    """A filter with a lag for each track; a track that is no longer in the picture is forgotten."""

    def __init__(self, filter: Any, lag: int) -> None:
        if filter.not_smoothed:
            raise ValueError(f"lag: cannot smooth {type(filter).__name__}: {filter.not_smoothed}")
        self.filter, self.lag = filter, lag
        self.each: dict[int, tuple[Any, list[float]]] = {}

    def take(self, picture: Picture, z: Array, sensor: int, covariance: Array | None) -> Estimate:
        """The estimate of each track of the picture, NaN where it has been there for fewer scans than the lag."""
        handed = [(now, self.each[before]) for now, before in picture.report["handed"] if before in self.each]
        self.each |= dict(handed)
        kept = {id_: self.each[id_] for id_ in picture.ids.tolist() if id_ in self.each}
        self.each, found, times = kept, [], []
        nothing = np.full(z.shape[1], np.nan)
        for id_, plot, time in zip(picture.ids.tolist(), picture.plot.tolist(), picture.times.tolist(), strict=True):
            if id_ not in self.each:
                self.each[id_] = self.filter.start(1, lag=self.lag), []
            live, before = self.each[id_]
            noise = None if covariance is None or plot < 0 else covariance[plot : plot + 1]
            row = z[plot] if plot >= 0 else nothing
            found.append(live.update(time, row[None], sensor=[sensor], covariance=noise).results)
            before.append(time)
            times.append(before.pop(0) if len(before) > self.lag else np.nan)
        return self._joined(found, times)

    def _joined(self, found: Sequence[dict[str, Array]], times: Sequence[float]) -> Estimate:
        f, n = self.filter, len(self.filter.components)
        shapes = {"x": (0, n), "P": (0, n, n), "mode_probability": (0, len(f.modes))}
        results = {
            name: np.concatenate([each[name] for each in found]) if found else np.empty(shapes[name])
            for name in OUTPUTS
        }
        results["time"] = np.asarray(times, dtype=float)
        for name in OUTPUTS:
            results[name][np.isnan(results["time"])] = np.nan
        return Estimate(f.components, f.modes, results, f.non_manoeuvring)
