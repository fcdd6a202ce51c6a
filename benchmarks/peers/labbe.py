"""FilterPy's interface, shared with its fork bayesian-filters: objects with attributes, one track each."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np

from ..cases import Case
from ..race import Job

ONE_BY_ONE = "one track after another in Python"


def kalman(library: ModuleType, case: Case) -> Job:
    """One KalmanFilter object per track."""

    def prepare() -> list[Any]:
        return [_filter(library, case, b, 0) for b in range(case.tracks)]

    return Job(lambda filters: _run(filters, case), case.updates, prepare, ONE_BY_ONE)


def imm(library: ModuleType, case: Case) -> Job:
    """One IMMEstimator of three KalmanFilter objects per track."""

    def prepare() -> list[Any]:
        return [_estimator(library, case, b) for b in range(case.tracks)]

    return Job(lambda filters: _run(filters, case), case.updates, prepare, ONE_BY_ONE)


def live(library: ModuleType, case: Case) -> Job:
    """One IMMEstimator; predict, update, read the state, scan by scan."""
    z = list(case.z)

    def run(estimator: Any) -> Any:
        estimator.update(z[0])
        for row in z[1:]:
            estimator.predict()
            estimator.update(row)
            x = estimator.x
        return x

    return Job(run, case.updates, lambda: _estimator(library, case, 0))


def _filter(library: ModuleType, case: Case, track: int, mode: int) -> Any:
    kf = library.KalmanFilter(dim_x=4, dim_z=2)
    kf.x, kf.P = case.x0[track].copy(), case.P0.copy()
    kf.F, kf.Q, kf.H, kf.R = case.F, case.Q[mode], case.H, case.R
    return kf


def _estimator(library: ModuleType, case: Case, track: int) -> Any:
    filters = [_filter(library, case, track, mode) for mode in range(len(case.Q))]
    return library.IMMEstimator(filters, case.mode_probability, case.transition)


def _run(filters: list[Any], case: Case) -> np.ndarray:
    states = np.empty((case.tracks, case.scans, 4))
    for b, z in enumerate(case.measurements()):
        estimator = filters[b]
        for k in range(case.scans):
            if k:
                estimator.predict()
            estimator.update(z[k])
            states[b, k] = estimator.x
    return states
