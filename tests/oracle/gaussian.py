"""Predict and update of one Gaussian: extended (first-order) and unscented, the update in Joseph's form.

The unscented forms are written as statistical linearisation, f(x) ~ mean + A (x - mean) + N(0, Omega), which
gives exactly the standard sigma-point mean and covariance (Julier & Uhlmann 1997; Sarkka, *Bayesian Filtering
and Smoothing*, 2013, 5.5).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oracle.motion import AXES, Motion
from oracle.sensor import wrap

Array = NDArray[np.float64]


@dataclass
class Predicted:
    """x, P before the update; A and noise of the (statistical) linearisation: P = A P0 A' + noise."""

    x: Array
    P: Array
    A: Array
    noise: Array


@dataclass
class Updated:
    x: Array
    P: Array
    innovation: Array
    S: Array
    log_likelihood: float


def symmetric(P: Array) -> Array:
    return (P + P.T) / 2


def sigma_points(x: Array, P: Array) -> Array:
    """The 2n points x +- sqrt(n) L_i, of equal weight 1/(2n), L the Cholesky factor of P."""
    n = len(x)
    L = np.sqrt(n) * np.linalg.cholesky(P)
    return np.vstack([x + L.T, x - L.T])


def linearise(points: Array, values: Array, x: Array, P: Array) -> tuple[Array, Array, Array]:
    """Mean, A and Omega of the statistical linearisation through sigma points and their images."""
    mean = values.mean(axis=0)
    dx, dy = points - x, values - mean
    A = np.linalg.solve(P, dx.T @ dy / len(points)).T
    Omega = dy.T @ dy / len(points) - A @ P @ A.T
    return mean, A, symmetric(Omega)


def predict(
    motion: Motion, x: Array, P: Array, dt: float, u: Array | None = None, linearisation="ekf", Q=None
) -> Predicted:
    """Q: the process noise, where it is not what the motion has at x."""
    Q = motion.noise(x, dt) if Q is None else Q
    if linearisation == "ekf":
        mean, A, noise = motion.f(x, dt), motion.F(x, dt), Q
    else:
        points = sigma_points(x, P)
        mean, A, Omega = linearise(points, np.array([motion.f(p, dt) for p in points]), x, P)
        noise = Q + Omega
    if u is not None:
        mean = mean + motion.input_matrix(dt) @ u
    return Predicted(mean, symmetric(A @ P @ A.T + noise), A, noise)


def parts(motion: Motion) -> tuple[list[int], list[int]]:
    """Where position and velocity lie in the state."""
    letters = AXES[: motion.axes]
    return [motion.index("p" + a) for a in letters], [motion.index("v" + a) for a in letters]


def update(motion: Motion, sensor, x: Array, P: Array, z: Array, R: Array, linearisation="ekf") -> Updated:
    """Joint update with the components of z that are not NaN."""
    position, velocity = parts(motion)
    present = np.flatnonzero(~np.isnan(z))

    def h(state):
        return sensor.h(state[position], state[velocity])

    def difference(a, b):
        d = a - b
        for i in sensor.angles:
            d[i] = wrap(d[i])
        return d

    at_x = h(x)
    if linearisation == "ekf":
        mean, H = at_x, np.zeros((len(at_x), motion.n))
        H[:, position], H[:, velocity] = sensor.H(x[position], x[velocity])
        Omega = np.zeros((len(at_x), len(at_x)))
    else:
        points = sigma_points(x, P)
        around = np.array([difference(h(p), at_x) for p in points])  # angles near at_x's, not across the wrap
        mean, H, Omega = linearise(points, around, x, P)
        mean = mean + at_x
    innovation = difference(z[: len(at_x)].copy(), mean)[present]
    H, noise = H[present], (R[: len(at_x), : len(at_x)] + Omega)[np.ix_(present, present)]
    S = symmetric(H @ P @ H.T + noise)
    K = np.linalg.solve(S, H @ P).T
    IKH = np.eye(motion.n) - K @ H
    logdet = np.linalg.slogdet(2 * np.pi * S)[1]
    log_likelihood = -0.5 * (logdet + innovation @ np.linalg.solve(S, innovation))
    return Updated(
        x + K @ innovation, symmetric(IKH @ P @ IKH.T + K @ noise @ K.T), innovation, S, float(log_likelihood)
    )
