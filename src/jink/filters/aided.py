"""A filter with a learned aid, which corrects the estimates that the filter gives out."""

from __future__ import annotations

from typing import Any

import numpy as np

from .._engine import native
from ..checks import with_attributes
from ..models.anfis import Anfis
from ..models.corrector import Corrector
from .bank import Bank
from .neural_vsmm import layers
from .parts import LARGEST_LAYER
from .plain import plain


class Aided(Bank):
    """x̂ + c(u): the estimates of ``filter`` with the correction of ``corrector`` along each axis added.

    u is what the corrector takes: the residual z − x̂(t|t) and the step x̂(t|t−1) − x̂(t|t), or the last innovations
    over their sd, or sums of these. The filter goes on from its own estimate; likelihood and NIS stay its own. P is the
    filter's, its sds times the corrector's ``sd_factors``. A miss, a rejected measurement or a start is not corrected.
    Errors: ValueError for units that do not go with the sensor, TypeError for a filter on models of your own. Source:
    Titi & Güney, "Adaptive neuro-fuzzy aided Kalman filter for target tracking".
    """

    arguments = ("corrector",)

    not_smoothed = "its aid was trained on filtered estimates; smooth the filter it aids, such as a jink.Kalman"

    def __init__(self, filter: Bank, corrector: Corrector) -> None:
        with_attributes("filter", filter, ("declaration", "sensors", "motions"), "a filter such as jink.Kalman")
        if not isinstance(corrector, Corrector):
            raise TypeError(f"corrector: expected a learned Corrector, got {type(corrector).__name__}")
        if isinstance(filter, Aided):
            raise TypeError("filter: already has a learned aid")
        if filter.declaration is None:
            raise TypeError("filter: an aid works only with jink's own motion and sensor models")
        self.filter_, self.corrector = filter, corrector
        self.motions, self.sensors = filter.motions, filter.sensors
        self.outliers, self.initial = filter.outliers, filter.initial
        sd = getattr(filter.sensors[0], "sd", None)
        if isinstance(sd, int | float):
            corrector.check_units(float(sd))
        self.declaration = native.Declaration(filter.declaration)
        self.declaration.aid = _native(corrector)
        self.engine = native.Engine(self.declaration)

    def described(self) -> dict[str, object]:
        """The filter under the aid, and the aid."""
        return {"filter": "Aided", "of": self.filter_.described(), "corrector": plain(self.corrector)}

    def __repr__(self) -> str:
        return f"Aided({self.filter_!r}, {type(self.corrector.model).__name__})"


def _native(c: Corrector) -> native.Aid:
    ranges = [float(v) for four in zip(c.low, c.high, c.centre, c.scale, strict=True) for v in four]
    numbers = [*ranges, *map(float, c.output_scale), float(c.fade), *c.factors]
    if isinstance(c.model, Anfis):
        model, sizes = native.AidModel[c.model.shape], [len(functions) for functions in c.model.memberships]
        largest, what = sum(sizes), "membership functions"
        numbers += [float(v) for functions in c.model.memberships for f in functions for v in f]
        numbers += np.asarray(c.model.consequents, dtype=float).ravel().tolist()
    else:
        model, (sizes, weights) = native.AidModel.network, layers(c.model)
        largest, what = max(sizes), "units in a layer"
        numbers += weights
    if largest > LARGEST_LAYER:
        raise ValueError(f"corrector: expected at most {LARGEST_LAYER} {what}, got {largest}")
    kind = native.AidInputs.residuals if c.inputs == "titi-guney" else native.AidInputs[c.inputs]
    return native.Aid(kind=kind, model=model, inputs=c.count, outputs=len(c.output_scale), sizes=sizes, numbers=numbers)


def unaided(filter: Any) -> Any:
    """The filter under an aid, or the filter itself."""
    return filter.filter_ if isinstance(filter, Aided) else filter
