"""A jink filter as Stone Soup's predictor and updater: its whole state travels with the states of the track."""

from __future__ import annotations

from datetime import datetime
from functools import cache
from typing import Any

import numpy as np

from ..filters.predicted_density import Density
from .needed import needed
from .stone_soup import START, _since


def pair(filter: Any, start: datetime = START) -> tuple[Any, Any]:
    """A ``Predictor`` and an ``Updater`` that run this filter, for Stone Soup's associators and trackers.

    A prior that they have not made is where the filter begins, with its mean and covariance in the filter's components.
    A detection's state vector is what the filter's sensor measures. Errors: ValueError for another number of
    components.
    """
    prediction_type, update_type, measured_type = _types()
    density = Density(filter.sensors[0], filter.components)

    def live_of(state: Any) -> Any:
        """A live target of its own that stands at this state."""
        if (kept := getattr(state, "live", None)) is not None:
            return filter.start(state=kept)
        mean = np.asarray(state.state_vector, dtype=float).ravel()
        if len(mean) != len(filter.components):
            raise ValueError(f"prior: has {len(mean)} components; expected {', '.join(filter.components)}")
        live = filter.start()
        live.begin(mean, np.asarray(state.covar, dtype=float), _since(state.timestamp, start))
        return live

    class JinkPredictor(needed("stonesoup.predictor").Predictor):
        """Where the filter expects the target."""

        def predict(self, prior: Any, timestamp: Any = None, **options: Any) -> Any:
            """The state at a time; the filter's own state before it goes along."""
            live, when = live_of(prior), prior.timestamp if timestamp is None else timestamp
            ahead = live.predict(_since(when, start))
            return prediction_type(
                ahead.x, ahead.P, timestamp=when, transition_model=None, prior=prior, live=live.save()
            )

    class JinkUpdater(needed("stonesoup.updater").Updater):
        """The filter's own update, from its state before the prediction."""

        def predict_measurement(self, predicted_state: Any, measurement_model: Any = None, **options: Any) -> Any:
            """What the sensor is expected to measure, linearised there."""
            x = np.asarray(predicted_state.state_vector, dtype=float).reshape(1, -1)
            P = np.asarray(predicted_state.covar, dtype=float)[None]
            z, H = density.expected(x, P)
            S = H[0] @ P[0] @ H[0].T + filter.sensors[0].noise
            cross = P[0] @ H[0].T
            return measured_type(z[0], S, timestamp=predicted_state.timestamp, cross_covar=cross)

        def update(self, hypothesis: Any, **options: Any) -> Any:
            """The state after the measurement."""
            live, detection = live_of(hypothesis.prediction), hypothesis.measurement
            z = np.asarray(detection.state_vector, dtype=float).ravel()
            now = live.update(_since(detection.timestamp, start), z)
            return update_type(now.x, now.P, timestamp=detection.timestamp, hypothesis=hypothesis, live=live.save())

    return JinkPredictor(transition_model=None), JinkUpdater(measurement_model=None)


@cache
def _types() -> tuple[type, type, type]:
    """States that carry the filter's state as bytes, and the measurement's prediction."""
    base = needed("stonesoup.base")
    predictions, updates = needed("stonesoup.types.prediction"), needed("stonesoup.types.update")

    class JinkState(needed("stonesoup.types.state").GaussianState):
        """A Gaussian state with the filter's own."""

        live: bytes = base.Property(default=None, doc="state of the filter")

    class JinkPrediction(predictions.Prediction, JinkState):
        """A prediction with the filter's state before it."""

    class JinkUpdate(updates.Update, JinkState):
        """An update with the filter's state after it."""

    return JinkPrediction, JinkUpdate, predictions.GaussianMeasurementPrediction
