"""quakfilter: an unscented Kalman filter and IMM in C++ for rigid bodies, 15 error states at least."""

from __future__ import annotations

from typing import Any

import numpy as np
from quak import IMMEstimator, RigidBodyCVModel

from ..cases import STEP, Case
from ..race import Job

NAME = "quakfilter"
DISTRIBUTION = "quakfilter"
CANNOT = {
    "kalman": "no linear Kalman filter and no 4-state model",
    "imm": "no 4-state model (its track pool holds rigid bodies)",
}
PLANAR = [0, 3, 1, 4]  # px vx py vy among its states
POSE = np.array([0, 0, 0, 1.0, 0, 0, 0])


def live(case: Case) -> Job:
    """An IMM of three rigid-body constant-velocity models measured as poses: its smallest three-mode IMM.

    Planar motion of the case sits in it exactly; altitude and attitude ride along, equal in every mode.
    """
    z = [np.concatenate([row, POSE[2:]]) for row in case.z]
    models = [RigidBodyCVModel() for _ in case.Q]
    noises = [_embed(Q, 1e-4) for Q in case.Q]
    measured = np.diag([case.R[0, 0]] * 3 + [0.01] * 3)

    def prepare() -> IMMEstimator:
        state = np.zeros(16)
        state[PLANAR], state[9] = case.x0[0], 1.0
        # it crashes on a correction before the first prediction: start one step earlier
        back = np.linalg.inv(case.F)
        state[PLANAR] = back @ case.x0[0]
        covariance = _embed(back @ case.P0 @ back.T, 1.0)
        return IMMEstimator(
            models,
            noises,
            measured,
            covariance,
            state,
            transition_matrix=case.transition,
            initial_probabilities=case.mode_probability,
            probability_floor=0.0,
        )

    def run(imm: Any) -> np.ndarray:
        for row in z:
            imm.predict(STEP)
            imm.correct(row)
            x = imm.state
        return x[PLANAR]

    return Job(run, case.updates, prepare, "15 error states, unscented, poses measured")


def _embed(planar: np.ndarray, rest: float) -> np.ndarray:
    matrix = rest * np.eye(15)
    matrix[np.ix_(PLANAR, PLANAR)] = planar
    return matrix
