"""Stone Soup: a framework for tracking; Kalman predictor and updater, one track at a time."""

from __future__ import annotations

import datetime
from typing import Any

import numpy as np
from stonesoup.models.measurement.linear import LinearGaussian
from stonesoup.models.transition.linear import LinearGaussianTimeInvariantTransitionModel
from stonesoup.predictor.kalman import KalmanPredictor
from stonesoup.types.detection import Detection
from stonesoup.types.hypothesis import SingleHypothesis
from stonesoup.types.prediction import GaussianStatePrediction
from stonesoup.updater.kalman import KalmanUpdater

from ..cases import Case
from ..race import Job
from .labbe import ONE_BY_ONE

NAME = "Stone Soup"
DISTRIBUTION = "stonesoup"
CANNOT = {"imm": "no IMM", "live": "no IMM"}
START = datetime.datetime(2024, 1, 1)


def kalman(case: Case) -> Job:
    """KalmanPredictor and KalmanUpdater with a single hypothesis per scan."""
    motion = LinearGaussianTimeInvariantTransitionModel(transition_matrix=case.F, covariance_matrix=case.Q[0])
    sensor = LinearGaussian(ndim_state=4, mapping=(0, 2), noise_covar=case.R)
    predictor, updater = KalmanPredictor(motion), KalmanUpdater(sensor)
    times = [START + datetime.timedelta(seconds=float(t)) for t in case.time[: case.scans]]

    def run(_: Any) -> np.ndarray:
        states = np.empty((case.tracks, case.scans, 4))
        for b, z in enumerate(case.measurements()):
            prediction: Any = GaussianStatePrediction(case.x0[b][:, None], case.P0, timestamp=times[0])
            for k in range(case.scans):
                detection = Detection(z[k][:, None], timestamp=times[k])
                state = updater.update(SingleHypothesis(prediction, detection))
                states[b, k] = state.state_vector[:, 0]
                if k + 1 < case.scans:
                    prediction = predictor.predict(state, timestamp=times[k + 1])
        return states

    return Job(run, case.updates, note=ONE_BY_ONE)
