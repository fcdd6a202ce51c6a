"""nrl-tracker: the U.S. Naval Research Laboratory's Tracker Component Library in Python."""

from __future__ import annotations

from typing import Any

import numpy as np
from pytcl.dynamic_estimation.imm import IMMEstimator
from pytcl.dynamic_estimation.kalman.linear import kf_predict, kf_update

from ..cases import Case
from ..race import Job
from .labbe import ONE_BY_ONE

NAME = "nrl-tracker"
DISTRIBUTION = "nrl-tracker"
CANNOT: dict[str, str] = {}


def kalman(case: Case) -> Job:
    """kf_predict and kf_update on each track."""
    F, Q, H, R = case.F, case.Q[0], case.H, case.R

    def run(_: Any) -> np.ndarray:
        states = np.empty((case.tracks, case.scans, 4))
        for b, z in enumerate(case.measurements()):
            x, P = case.x0[b], case.P0
            for k in range(case.scans):
                if k:
                    x, P = kf_predict(x, P, F, Q)
                x, P, *_ = kf_update(x, P, z[k], H, R)
                states[b, k] = x
        return states

    return Job(run, case.updates, note=ONE_BY_ONE)


def imm(case: Case) -> Job:
    """One IMMEstimator per track."""

    def run(filters: list[IMMEstimator]) -> np.ndarray:
        states = np.empty((case.tracks, case.scans, 4))
        for b, z in enumerate(case.measurements()):
            states[b, 0] = filters[b].update(z[0]).x
            for k in range(1, case.scans):
                states[b, k] = filters[b].predict_update(z[k]).x
        return states

    return Job(run, case.updates, lambda: [_imm(case, b) for b in range(case.tracks)], ONE_BY_ONE)


def live(case: Case) -> Job:
    """One IMMEstimator, scan by scan."""
    z = list(case.z)

    def run(estimator: IMMEstimator) -> np.ndarray:
        x = estimator.update(z[0]).x
        for row in z[1:]:
            x = estimator.predict_update(row).x
        return x

    return Job(run, case.updates, lambda: _imm(case, 0))


def _imm(case: Case, track: int) -> IMMEstimator:
    estimator = IMMEstimator(len(case.Q), 4, case.transition)
    estimator.initialize(case.x0[track], case.P0, case.mode_probability)
    for mode, Q in enumerate(case.Q):
        estimator.set_mode_model(mode, case.F, Q)
    estimator.set_measurement_model(case.H, case.R)
    return estimator
