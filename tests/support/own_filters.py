"""A user's file: whole filters, a motion model and functions of the purpose, as races and fits take them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import jink


def white(psd, dt):
    Q = np.zeros((len(dt), 4, 4))
    for p in (0, 2):
        Q[:, p, p], Q[:, p + 1, p + 1] = psd * dt**3 / 3, psd * dt
        Q[:, p, p + 1] = Q[:, p + 1, p] = psd * dt**2 / 2
    return Q


@dataclass
class Straight:
    """Constant velocity as a whole filter; the same as Kalman with OnePoint(velocity_sd=300)."""

    acceleration_psd: float = 4.0

    def begin(self, z, R):
        x, P = np.zeros((len(z), 4)), np.zeros((len(z), 4, 4))
        x[:, ::2] = z
        P[:, 0, 0], P[:, 2, 2], P[:, 0, 2] = R[:, 0, 0], R[:, 1, 1], R[:, 0, 1]
        P[:, 2, 0] = P[:, 0, 2]
        P[:, 1, 1] = P[:, 3, 3] = 300.0**2
        return {"x": x, "P": P}

    def step(self, state, dt, z, R):
        x, P = state["x"], state["P"]
        F = np.tile(np.eye(4), (len(x), 1, 1))
        F[:, 0, 1] = F[:, 2, 3] = dt
        x, P = (F @ x[..., None])[..., 0], F @ P @ F.swapaxes(1, 2) + white(self.acceleration_psd, dt)
        there = np.isfinite(z).all(axis=1)
        H = np.eye(4)[::2]
        S = H @ P @ H.T + R
        K = P @ H.T @ np.linalg.inv(S)
        residual = np.where(there[:, None], z - x[:, ::2], 0.0)
        state["x"] = x + (K @ residual[..., None])[..., 0]
        state["P"] = np.where(there[:, None, None], P - K @ S @ K.swapaxes(1, 2), P)
        return state


@dataclass
class Drifting:
    """A motion model: constant velocity again."""

    acceleration_psd: float = 4.0

    def f(self, x, dt):
        F = np.tile(np.eye(4), (len(x), 1, 1))
        F[:, 0, 1] = F[:, 2, 3] = dt
        return (F @ x[..., None])[..., 0]

    def Q(self, dt):
        return white(self.acceleration_psd, dt)


def make(purpose):
    """The same filter by jink's own parts."""
    motion = jink.ConstantVelocity(acceleration_psd=4.0)
    return jink.Kalman(motion, purpose.sensor, initial=jink.OnePoint(velocity_sd=300.0))


def several_models(purpose):
    """Own models in an IMM."""
    return jink.IMM([Drifting(0.1), Drifting(50.0)], purpose.sensor, 0.95)


def failing(purpose):
    raise RuntimeError("own trouble")


everything = {"mine": Straight(), "made": make, "imm": None}
