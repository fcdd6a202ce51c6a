"""A filter with a learned aid: a correction of what goes out, on top of any filter."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from .. import _engine
from ..models.anfis import Anfis
from ..models.corrector import Corrector
from .bank import Bank
from .neural_vsmm import layers
from .parts import Parts
from .plain import plain

RESIDUALS, INNOVATIONS = 1, 2
MODELS = {"triangular": 1, "gaussian": 2, "bell": 3}  # of an ANFIS; a network is 0


class Aided(Bank):
    """x̂ + c(u): the estimates of ``filter`` with the correction of ``corrector`` along each axis added.

    u is what the corrector takes: the residual z − x̂(t|t) and the step x̂(t|t−1) − x̂(t|t), or the last innovations over their sd. The
    filter goes on from its own estimate; P, likelihood and NIS stay its own. A miss, a rejected measurement or a start is not
    corrected. Errors: ValueError for units that do not go with the sensor, TypeError for a filter on models of your own.
    Source: Titi & Güney, "Adaptive neuro-fuzzy aided Kalman filter for target tracking".
    """

    arguments = ("corrector",)

    not_smoothed = (
        "its aid was trained on filtered estimates; smooth the filter it aids, such as a jink.Kalman"
    )

    def __init__(self, filter: Bank, corrector: Corrector) -> None:
        if isinstance(filter, Aided):
            raise TypeError("filter: is aided already")
        if filter._declared is None:
            raise TypeError("filter: an aid runs on jink's own motion and sensor models")
        self.filter_, self.corrector = filter, corrector
        self.motions, self.sensors = filter.motions, filter.sensors
        self.outliers, self.initial = filter.outliers, filter.initial
        sd = getattr(filter.sensors[0], "sd", None)
        if isinstance(sd, int | float):
            corrector.check_units(float(sd))
        modes, sensors, rules, parts = filter._declared
        self._declared = (modes, sensors, rules, replace(parts or Parts(), aid=_native(corrector)))
        self._engine = _engine.Engine(modes, sensors, *rules, *self._declared[3].native(self.axes))

    def described(self) -> dict[str, Any]:
        """The filter under the aid, and the aid."""
        return {"filter": "Aided", "of": self.filter_.described(), "corrector": plain(self.corrector)}

    def __repr__(self) -> str:
        return f"Aided({self.filter_!r}, {type(self.corrector.model).__name__})"


def _native(c: Corrector) -> tuple[int, int, int, int, list[int], list[float]]:
    ranges = [float(v) for four in zip(c.low, c.high, c.centre, c.scale, strict=True) for v in four]
    numbers = [*ranges, *map(float, c.output_scale), float(c.fade)]
    kind = RESIDUALS if c.inputs == "titi-guney" else INNOVATIONS
    if isinstance(c.model, Anfis):
        m = c.model
        sizes = [len(functions) for functions in m.memberships]
        if sum(sizes) > 128:
            raise ValueError(f"corrector: expected at most 128 membership functions, got {sum(sizes)}")
        numbers += [float(v) for functions in m.memberships for f in functions for v in f]
        numbers += np.asarray(m.consequents, dtype=float).ravel().tolist()
        return kind, MODELS[m.shape], c.count, len(c.output_scale), sizes, numbers
    sizes, weights = layers(c.model)
    if max(sizes) > 128:
        raise ValueError(f"corrector: expected layers of at most 128, got {max(sizes)}")
    return kind, 0, c.count, len(c.output_scale), sizes, [*numbers, *weights]


def unaided(filter: Any) -> Any:
    """The filter under an aid, or the filter itself."""
    return filter.filter_ if isinstance(filter, Aided) else filter
