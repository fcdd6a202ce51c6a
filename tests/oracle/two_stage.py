"""Acceleration of one axis as a bias: the two-stage estimator in its literal form, and the augmented filter.

Friedland, "Treatment of bias in recursive filtering", IEEE T-AC 14(4), 1969; Alouani, Xia, Rice & Blair,
"A two-stage Kalman estimator for state estimation in the presence of random bias ...", CDC 1991, as printed in
Lee, Joo & Park 2002, section 2. Tracks (B,), one axis: z (B, N), NaN where missing.

Readings. The printed S(k) = H U(k-1) is S(k) = H U(k), the sensitivity of this scan's residual. `bias_sd` and
`sd` are standard deviations of noise per scan, whatever its length; over no time there is none. The bias acts
between the two points of the start as well, v = (z2 - z1)/T + a T/2, so V = [0; T/2] there, which P = [R, R/T;
R/T, 2R/T^2] of the bias-free part leaves open.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
H = np.array([[1.0, 0.0]])


@dataclass
class Traced:
    """x (B, N, 3) = [p v a] and P (B, N, 3, 3); NaN before the second row."""

    x: Array
    P: Array


@dataclass
class TwoStage:
    """Bias-free x (B, 2), P (2, 2); bias a (B,), M (1, 1); sensitivity V (2, 1), one P, M, V per track."""

    x: Array
    P: Array
    a: Array
    M: Array
    V: Array

    def output(self) -> tuple[Array, Array]:
        """x = bias-free + V a, P = bias-free + V M V', with cov(x, a) = V M."""
        x = np.concatenate([self.x + self.V[..., 0] * self.a[:, None], self.a[:, None]], axis=1)
        to = np.concatenate([self.V, np.ones((len(self.V), 1, 1))], axis=1)
        P = to @ self.M @ np.swapaxes(to, 1, 2)
        P[:, :2, :2] += self.P
        return x, P


def dynamics(dt: float) -> tuple[Array, Array]:
    return np.array([[1.0, dt], [0.0, 1.0]]), np.array([[dt**2 / 2], [dt]])


def begin(time: Array, z: Array, R: float, bias_prior: float) -> TwoStage:
    """Two points, no acceleration yet, its variance bias_prior."""
    T, B = time[1] - time[0], len(z)
    P = R * np.array([[1, 1 / T], [1 / T, 2 / T**2]])
    x = np.stack([z[:, 1], (z[:, 1] - z[:, 0]) / T], axis=1)
    return TwoStage(
        x,
        np.tile(P, (B, 1, 1)),
        np.zeros(B),
        np.full((B, 1, 1), bias_prior),
        np.tile([[0.0], [T / 2]], (B, 1, 1)),
    )


def scan(s: TwoStage, z: Array, R: float, dt: float, sd: float, bias_sd: float) -> TwoStage:
    """One scan of both filters; a missing measurement leaves the predictions."""
    F, G = dynamics(dt)
    x, P = s.x @ F.T, F @ s.P @ F.T + sd**2 * G @ G.T  # bias-free, as if there were no acceleration
    M = s.M + (bias_sd**2 if dt > 0 else 0.0)
    U = F @ s.V + G
    S = H @ U
    there = ~np.isnan(z)
    on = there[:, None, None]
    residual = np.where(there, z - x[:, 0], 0.0)
    variance = H @ P @ H.T + R
    K = np.where(on, P @ H.T / variance, 0.0)
    gain = np.where(on, M * S / (S * M * S + variance), 0.0)
    keep = np.eye(2) - K @ H
    a = s.a + gain[:, 0, 0] * (residual - S[:, 0, 0] * s.a)
    P = keep @ P @ np.swapaxes(keep, 1, 2) + K * R @ np.swapaxes(K, 1, 2)
    return TwoStage(x + K[..., 0] * residual[:, None], P, a, (1 - gain * S) * M, keep @ U)


def two_stage(time: Array, z: Array, R: float, sd: float, bias_sd: float, bias_prior: float) -> Traced:
    state = begin(time, z, R, bias_prior)
    out = Traced(np.full((*z.shape, 3), np.nan), np.full((*z.shape, 3, 3), np.nan))
    for k in range(1, len(time)):
        if k > 1:
            state = scan(state, z[:, k], R, time[k] - time[k - 1], sd, bias_sd)
        out.x[:, k], out.P[:, k] = state.output()
    return out


def augmented(
    time: Array, z: Array, R: float, sd: float, bias_sd: float, bias_prior: float, published: bool = False
) -> Traced:
    """Optimal filter of [p v a]: F = [1 T T^2/2; 0 1 T; 0 0 1], Q = sd^2 G G' on p, v plus bias_sd^2 on a.

    published: with bias_sd^2 [U; 1][U; 1]' instead, U = (F P_xa + G P_aa)/P_aa. That is what the two-stage
    recursion does: its new bias is taken to have acted, through U, since the start, not from now on.
    """
    first = begin(time, z, R, bias_prior)
    x, P = first.output()
    H3 = np.array([[1.0, 0.0, 0.0]])
    out = Traced(np.full((*z.shape, 3), np.nan), np.full((*z.shape, 3, 3), np.nan))
    out.x[:, 1], out.P[:, 1] = x, P
    for k in range(2, len(time)):
        dt = time[k] - time[k - 1]
        F, G = dynamics(dt)
        A = np.block([[F, G], [np.zeros((1, 2)), np.ones((1, 1))]])
        Q = np.zeros((3, 3))
        Q[:2, :2] = sd**2 * G @ G.T
        w = np.zeros((len(z), 3, 1))
        w[:, 2] = 1.0
        if published:
            w[:, :2] = (F @ P[:, :2, 2:] + G @ P[:, 2:, 2:]) / P[:, 2:, 2:]
        x = x @ A.T
        P = A @ P @ A.T + Q + (bias_sd**2 if dt > 0 else 0.0) * w @ np.swapaxes(w, 1, 2)
        there = ~np.isnan(z[:, k])
        K = np.where(there[:, None, None], P @ H3.T / (H3 @ P @ H3.T + R), 0.0)
        keep = np.eye(3) - K @ H3
        x = x + K[..., 0] * np.where(there, z[:, k] - x[:, 0], 0.0)[:, None]
        P = keep @ P @ np.swapaxes(keep, 1, 2) + K * R @ np.swapaxes(K, 1, 2)
        out.x[:, k], out.P[:, k] = x, P
    return out
