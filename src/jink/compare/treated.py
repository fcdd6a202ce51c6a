"""Filters that take part in another way than as they are: with the noise of the data, or with a lag."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ..io.errors import InputError
from ..models.sensor import Sensor
from ..tracking.lag import Lag
from .entrants import Entrant

NOISE_OF_DATA = "its own measurement noise is not that of the data, which it is given"


class Treated:
    """A filter that is told the covariance of each measurement, or waits for later ones; the rest of it is its own."""

    def __init__(self, filter: Any, *, R: np.ndarray | None = None, smoothing: Mapping[str, Any] | None = None) -> None:
        self._filter, self._R, self._smoothing = filter, R, smoothing

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._filter, name)

    def filter(self, time: Any, z: Any, **options: Any) -> Any:
        """As the filter's own, or its fixed-lag smoother."""
        if self._R is not None:
            options["covariance"] = np.broadcast_to(self._R, (len(z), *self._R.shape))
        if self._smoothing is None:
            return self._filter.filter(time, z, **options)
        return self._filter.smooth(time, z, **self._smoothing, **options)


def with_noise_of(entrant: Entrant, sensor: Sensor) -> Entrant:
    """A filter from a file with the measurement noise of the data, unless it was fitted on such data itself.

    Errors: InputError where it cannot be given that noise.
    """
    if not entrant.note or entrant.fitted:
        return entrant
    R = np.asarray(sensor.noise)
    if entrant.filter.axes == 1 and len(R) > 1:
        if not np.allclose(R, R[0, 0] * np.eye(len(R))):
            raise InputError(
                f"{entrant.name}: a filter of one axis has one measurement noise; expected the same on all axes, "
                "as the data has not"
            )
        R = R[:1, :1]
    return replace(entrant, filter=Treated(entrant.filter, R=R), note=NOISE_OF_DATA)


def lagged(entrants: Mapping[str, Entrant], lag: Lag) -> tuple[dict[str, Entrant], dict[str, str]]:
    """The same filters with a lag, by names that say so, and those that cannot be smoothed, with the reason."""
    found: dict[str, Entrant] = {}
    skipped: dict[str, str] = {}
    for name, entrant in entrants.items():
        if entrant.filter is None:
            continue
        late = f"{name}, lag {lag}"
        if why := getattr(entrant.filter, "not_smoothed", ""):
            skipped[late] = f"it cannot be smoothed: {why}"
            continue
        filter = Treated(entrant.filter, smoothing=lag.options())
        found[late] = replace(
            entrant, name=late, words=f"{entrant.words}; uses what is measured {lag} later", filter=filter
        )
    return found, skipped
