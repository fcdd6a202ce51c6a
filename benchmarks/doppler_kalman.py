"""The linear filter of the Doppler race, for all targets at once: constant velocity, on positions and range rates."""

from __future__ import annotations

import numpy as np

from .doppler_targets import STEP, Flights

F = np.eye(6) + STEP * np.eye(6, k=3)
START = 1e3  # variance of every component of a first state, as in the package


def estimated_noise(flights: Flights) -> tuple[np.ndarray, np.ndarray]:
    """Q and R, the covariances of what the models leave of the truth: x(k+1) − F x(k), and z − H x."""
    inner = np.ones(len(flights.time), bool)
    inner[flights.offsets[1:] - 1] = False
    at = np.flatnonzero(inner)
    Q = np.cov((flights.truth[at + 1] - flights.truth[at] @ F.T).T)
    H = lines_of_sight(flights.truth[:, :3])
    return Q, np.cov((plots(flights) - np.einsum("nij,nj->ni", H, flights.truth)).T)


def kalman(flights: Flights, Q: np.ndarray, R: np.ndarray) -> np.ndarray:
    """States (N, 6). A first state is the plot's position at rest; the line of sight is always the plot's."""
    z, H, lengths = plots(flights), lines_of_sight(flights.positions), np.diff(flights.offsets)
    out, x = np.empty((len(z), 6)), np.zeros((len(lengths), 6))
    P = np.tile(START * np.eye(6), (len(lengths), 1, 1))
    for k in range(int(lengths.max())):
        on = np.flatnonzero(lengths > k)
        row = flights.offsets[on] + k
        if k:
            x[on], P[on] = x[on] @ F.T, F @ P[on] @ F.T + Q
        h = H[row]
        K = np.linalg.solve(h @ P[on] @ h.transpose(0, 2, 1) + R, h @ P[on]).transpose(0, 2, 1)
        left = np.eye(6) - K @ h
        P[on] = left @ P[on] @ left.transpose(0, 2, 1) + K @ R @ K.transpose(0, 2, 1)
        if k:
            x[on] += np.einsum("nij,nj->ni", K, z[row] - np.einsum("nij,nj->ni", h, x[on]))
        else:
            x[on, :3] = z[row, :3]
        out[row] = x[on]
    return out


def plots(flights: Flights) -> np.ndarray:
    """Measured x, y, z and range rate, (N, 4)."""
    return np.column_stack([flights.positions, flights.z[:, 3]])


def lines_of_sight(position: np.ndarray) -> np.ndarray:
    """H (N, 4, 6) of position and range rate seen from the radar along these positions."""
    H = np.zeros((len(position), 4, 6))
    H[:, :3, :3] = np.eye(3)
    H[:, 3, 3:] = position / np.linalg.norm(position, axis=1, keepdims=True)
    return H
