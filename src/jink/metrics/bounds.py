"""What no filter can beat: the posterior Cramér–Rao bound, where it is defined."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..checks import Array, by_hints
from .figure import present


@by_hints
def turn_displacement(velocity: ArrayLike, turn_rate: ArrayLike, time: ArrayLike) -> Array:
    """What turning at a known rate adds to constant velocity, (runs, scans, axes, 2).

    [T (S(ωT) − I) v, (R(ωT) − I) v] with the true velocity v (runs, scans, axes) of the scan before and the rate ω
    (runs, scans) since then (rad/s, counter-clockwise); axes beyond the second do not turn.
    """
    v, rate = np.asarray(velocity, dtype=float), np.asarray(turn_rate, dtype=float)
    T = np.diff(np.broadcast_to(np.asarray(time, dtype=float), rate.shape), axis=1)
    half = rate[:, 1:] * T / 2
    before = v[:, :-1, 0] + 1j * v[:, :-1, 1]
    chord = T * (np.sinc(half / np.pi) * np.exp(1j * half) - 1) * before
    turned = (np.exp(2j * half) - 1) * before
    out = np.zeros((*v.shape, 2))
    out[:, 1:, 0] = np.stack([chord.real, turned.real], axis=-1)
    out[:, 1:, 1] = np.stack([chord.imag, turned.imag], axis=-1)
    return out


@by_hints
def information(jacobians: ArrayLike, R: ArrayLike) -> Array:
    """Mean information of each scan's measurement, E[Hᵀ R⁻¹ H], (scans, n, n).

    jacobians H (runs, scans, m, n) of the sensor at the truth, NaN rows where it is missed; R (m, m).
    """
    H, noise = np.asarray(jacobians, dtype=float), np.asarray(R, dtype=float)
    if H.ndim != 4 or noise.shape != (H.shape[2], H.shape[2]):
        raise ValueError(f"jacobians, R: expected (runs, scans, m, n) and (m, m), got {H.shape} and {noise.shape}")
    seen = present(H, 2)
    H = np.where(seen[..., None, None], H, 0.0)
    return np.einsum("rkmi,mp,rkpj->kij", H, np.linalg.inv(noise), H, optimize=True) / len(H)


@by_hints
def posterior_bound(F: ArrayLike, Q: ArrayLike, information: ArrayLike, P0: ArrayLike) -> Array:
    """Posterior Cramér–Rao bound on any filter's covariance, (scans, n, n), for linear motion.

    C_k⁻¹ = (F C_{k−1} Fᵀ + Q)⁻¹ + E[Hᵀ R⁻¹ H], from C_0⁻¹ = P0⁻¹ + the first scan's information. For a linear
    sensor this is the Riccati recursion. F, Q (n, n) or (scans, n, n), into each scan; information (scans, n, n);
    P0 (n, n) before the first measurement. Q may be singular.
    Source: Tichavský, Muravchik & Nehorai, IEEE Trans. SP 46(5), 1998.
    """
    J = np.asarray(information, dtype=float)
    scans, n, _ = J.shape
    Fs, Qs = (np.broadcast_to(np.asarray(a, dtype=float), (scans, n, n)) for a in (F, Q))
    C = np.empty((scans, n, n))
    predicted = np.asarray(P0, dtype=float)
    for k in range(scans):
        if k:
            predicted = Fs[k] @ C[k - 1] @ Fs[k].T + Qs[k]
        C[k] = _updated(predicted, J[k])
    return C


def _updated(P: Array, J: Array) -> Array:
    """(P⁻¹ + J)⁻¹ = P (I + J P)⁻¹, without inverting P."""
    C = P @ np.linalg.inv(np.eye(len(P)) + J @ P)
    return (C + C.T) / 2


@by_hints
def tichavsky_bound(F: ArrayLike, Q: ArrayLike, information: ArrayLike, P0: ArrayLike) -> Array:
    """Posterior Cramér–Rao bound for motion that is not linear, J⁻¹ (scans, n, n).

    J_k = D22 − D21 (J_{k−1} + D11)⁻¹ D12 + E[Hᵀ R⁻¹ H],
    D11 = E[Fᵀ Q⁻¹ F], D12 = −E[Fᵀ] Q⁻¹ = D21ᵀ, D22 = Q⁻¹.
    F (runs, scans, n, n) = ∂f/∂x at each run's truth, into each scan; Q (n, n) or (scans, n, n), regular;
    information (scans, n, n); P0 (n, n). Errors: ValueError for a singular Q, where this form is not defined.
    Source: Tichavský, Muravchik & Nehorai, IEEE Trans. SP 46(5), 1998 (additive Gaussian noise).
    """
    jacobians, J_z = np.asarray(F, dtype=float), np.asarray(information, dtype=float)
    scans, n, _ = J_z.shape
    noise = np.broadcast_to(np.asarray(Q, dtype=float), (scans, n, n))
    C = np.empty((scans, n, n))
    J = np.linalg.inv(np.asarray(P0, dtype=float)) + J_z[0]
    C[0] = np.linalg.inv(J)
    for k in range(1, scans):
        if np.linalg.matrix_rank(noise[k]) < n:
            raise ValueError(
                f"Q: expected a regular matrix, got a singular one in scan {k}; use posterior_bound for linear motion"
            )
        precision = np.linalg.inv(noise[k])
        D11 = np.einsum("rji,jl,rlm->im", jacobians[:, k], precision, jacobians[:, k], optimize=True) / len(jacobians)
        D12 = -jacobians[:, k].mean(axis=0).T @ precision
        J = precision - D12.T @ np.linalg.solve(J + D11, D12) + J_z[k]
        C[k] = np.linalg.inv(J)
    return C


@by_hints
def bound_rmse(C: ArrayLike, index: ArrayLike, *, first: int = 0) -> float:
    """RMSE over scans ≥ first that the bound C (scans, n, n) allows for the components ``index`` together."""
    variances = np.diagonal(np.asarray(C, dtype=float), axis1=1, axis2=2)[first:]
    return float(np.sqrt(variances[:, np.asarray(index)].sum(axis=1).mean()))
