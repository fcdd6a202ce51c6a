"""simdkalman: one Kalman filter over many series at once, NumPy along the tracks."""

from __future__ import annotations

import numpy as np
import simdkalman

from ..cases import Case
from ..race import Job

NAME = "simdkalman"
DISTRIBUTION = "simdkalman"
CANNOT = {"imm": "no IMM", "live": "no IMM"}


def kalman(case: Case) -> Job:
    """KalmanFilter.update and predict_next, scan by scan; `compute` does that and stores covariances too."""
    kf = simdkalman.KalmanFilter(case.F, case.Q[0], case.H, case.R)
    z = np.ascontiguousarray(case.measurements().transpose(1, 0, 2))[..., None]

    def run(_: None) -> np.ndarray:
        states = np.empty((case.scans, case.tracks, 4))
        m, P = case.x0[..., None], np.tile(case.P0, (case.tracks, 1, 1))
        for k in range(case.scans):
            if k:
                m, P = kf.predict_next(m, P)
            m, P, *_ = kf.update(m, P, z[k])
            states[k] = m[..., 0]
        return states.transpose(1, 0, 2)

    return Job(run, case.updates)
