"""The textbook filters every library is checked against before it is timed. Slow and obvious.

Bar-Shalom, Li, Kirubarajan, "Estimation with Applications to Tracking and Navigation", 2001: Kalman filter
5.2.4, IMM 11.6.6.
"""

from __future__ import annotations

import numpy as np

from .cases import Array, Case


def kalman(case: Case) -> Array:
    """States x(k|k) of the Kalman filter with the case's first process noise, shape (B, S, 4)."""
    states = np.empty((case.tracks, case.scans, 4))
    for b, z in enumerate(case.measurements()):
        x, P = case.x0[b], case.P0
        for k in range(case.scans):
            if k:
                x, P = case.F @ x, case.F @ P @ case.F.T + case.Q[0]
            x, P, _ = _update(case, x, P, z[k])
            states[b, k] = x
    return states


def imm(case: Case) -> tuple[Array, Array]:
    """States (B, S, 4) and mode probabilities (B, S, M) of the IMM over the case's process noises."""
    modes = range(len(case.Q))
    states = np.empty((case.tracks, case.scans, 4))
    probabilities = np.empty((case.tracks, case.scans, len(modes)))
    for b, z in enumerate(case.measurements()):
        x = np.tile(case.x0[b], (len(modes), 1))
        P = np.tile(case.P0, (len(modes), 1, 1))
        mu = case.mode_probability
        for k in range(case.scans):
            if k:
                x, P, mu = _mix(case, x, P, mu)
                x = x @ case.F.T
                P = case.F @ P @ case.F.T + case.Q
            updated = [_update(case, x[j], P[j], z[k]) for j in modes]
            x, P = np.stack([u[0] for u in updated]), np.stack([u[1] for u in updated])
            mu = mu * np.array([u[2] for u in updated])
            mu = mu / mu.sum()
            states[b, k], probabilities[b, k] = mu @ x, mu
    return states, probabilities


def _mix(case: Case, x: Array, P: Array, mu: Array) -> tuple[Array, Array, Array]:
    predicted = case.transition.T @ mu
    weight = case.transition * mu[:, None] / predicted
    mixed = weight.T @ x
    spread = np.zeros_like(P)
    for j in range(len(mu)):
        for i in range(len(mu)):
            d = x[i] - mixed[j]
            spread[j] += weight[i, j] * (P[i] + np.outer(d, d))
    return mixed, spread, predicted


def _update(case: Case, x: Array, P: Array, z: Array) -> tuple[Array, Array, float]:
    v = z - case.H @ x
    S = case.H @ P @ case.H.T + case.R
    K = P @ case.H.T @ np.linalg.inv(S)
    J = np.eye(4) - K @ case.H
    likelihood = np.exp(-0.5 * v @ np.linalg.solve(S, v)) / np.sqrt(np.linalg.det(2 * np.pi * S))
    return x + K @ v, J @ P @ J.T + K @ case.R @ K.T, float(likelihood)
