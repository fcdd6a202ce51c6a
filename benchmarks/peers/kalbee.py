"""kalbee: NumPy filters; its Kalman filter has a batched form, its IMM has not."""

from __future__ import annotations

from typing import Any

import numpy as np
from kalbee.modules.filters.imm_filter import InteractingMultipleModel
from kalbee.modules.filters.kf_filter import KalmanFilter
from kalbee.modules.filters.vectorized_kf import VectorizedKalmanFilter

from ..cases import Case
from ..race import Job
from .labbe import ONE_BY_ONE

NAME = "kalbee"
DISTRIBUTION = "kalbee"
CANNOT: dict[str, str] = {}


def kalman(case: Case) -> Job:
    """VectorizedKalmanFilter: all tracks at once, scan by scan."""
    z = np.ascontiguousarray(case.measurements().transpose(1, 0, 2))[..., None]

    def prepare() -> VectorizedKalmanFilter:
        covariance = np.tile(case.P0, (case.tracks, 1, 1))
        return VectorizedKalmanFilter(case.x0[..., None], covariance, case.F, case.Q[0], case.H, case.R)

    def run(kf: VectorizedKalmanFilter) -> np.ndarray:
        states = np.empty((case.scans, case.tracks, 4))
        for k in range(case.scans):
            if k:
                kf.predict()
            states[k] = kf.update(z[k])[..., 0]
        return states.transpose(1, 0, 2)

    return Job(run, case.updates, prepare)


def imm(case: Case) -> Job:
    """One InteractingMultipleModel per track."""
    z = case.measurements()[..., None]

    def run(filters: list[Any]) -> np.ndarray:
        states = np.empty((case.tracks, case.scans, 4))
        for b, estimator in enumerate(filters):
            for k in range(case.scans):
                if k:
                    estimator.predict()
                states[b, k] = estimator.update(z[b, k])[:, 0]
        return states

    return Job(run, case.updates, lambda: [_imm(case, b) for b in range(case.tracks)], ONE_BY_ONE)


def live(case: Case) -> Job:
    """One InteractingMultipleModel, scan by scan."""
    z = list(case.z[..., None])

    def run(estimator: InteractingMultipleModel) -> np.ndarray:
        x = estimator.update(z[0])
        for row in z[1:]:
            estimator.predict()
            x = estimator.update(row)
        return x[:, 0]

    return Job(run, case.updates, lambda: _imm(case, 0))


def _imm(case: Case, track: int) -> InteractingMultipleModel:
    x = case.x0[track][:, None]
    filters: list[Any] = [KalmanFilter(x.copy(), case.P0.copy(), case.F, Q, case.H, case.R) for Q in case.Q]
    return InteractingMultipleModel(filters, case.transition, case.mode_probability)
