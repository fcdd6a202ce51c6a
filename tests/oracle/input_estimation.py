"""Input estimation: a constant acceleration of unknown onset, found in the residuals of a quiet filter.

Chan, Hu & Plant, IEEE T-AES 15(2), 1979; Bogler, "Tracking a maneuvering target using input estimation",
IEEE T-AES 23(3), 1987 (the onset is estimated too). One track, z (N, axes), NaN where missing.

Had u acted since an onset, the filter without it would be wrong by M u and its residual by Psi u on the mean:
    M- = F M + G,  Psi = H M-,  M = (I - K H) M-,   Y += Psi' S^-1 Psi,  y += Psi' S^-1 nu,
so u = Y^-1 y with covariance Y^-1, and y' Y^-1 y is chi-square with `axes` degrees of freedom without one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oracle.many import measure_matrix, predict, started, update
from oracle.mixture import Mode
from oracle.motion import Motion

Array = NDArray[np.float64]


@dataclass
class Onset:
    """One hypothesis: sensitivity M (n, axes), information Y and y of the residuals since."""

    M: Array
    Y: Array
    y: Array

    @property
    def significance(self) -> float:
        """y' Y^-1 y; 0 while the residuals do not determine every axis."""
        if np.linalg.matrix_rank(self.Y) < len(self.Y):
            return 0.0
        return float(self.y @ np.linalg.solve(self.Y, self.y))


@dataclass
class Estimated:
    """x (N, n), P (N, n, n), where a manoeuvre was detected (N,), and its input u (N, axes), NaN elsewhere."""

    x: Array
    P: Array
    detected: NDArray[np.bool_]
    u: Array


def input_estimation(
    motion: Motion, time: Array, z: Array, R: Array, window: int, threshold: float, shortest: int = 1
) -> Estimated:
    """A new onset with every scan (the input acts since the scan before), the oldest beyond `window` dropped.

    When max over onsets of y' Y^-1 y exceeds the threshold: x += M u, P += M Y^-1 M', and all hypotheses
    begin anew. An input that goes on is found again. Only onsets at least `shortest` scans old are asked; of those
    that explain the residuals equally well (one residual does not tell them apart) the oldest is taken.
    """
    N, axes = z.shape
    start = started([motion], time, z[None, :2], R)[0]
    mode, onsets = Mode(start.x[0], start.P[0]), []
    out = Estimated(
        np.full((N, motion.n), np.nan),
        np.full((N, motion.n, motion.n), np.nan),
        np.zeros(N, bool),
        np.full((N, axes), np.nan),
    )
    out.x[1], out.P[1] = mode.x, mode.P
    for k in range(2, N):
        mode, onsets, u = scan(motion, mode, onsets, z[k], R, time[k] - time[k - 1], window, threshold, shortest)
        if u is not None:
            out.detected[k], out.u[k] = True, u
        out.x[k], out.P[k] = mode.x, mode.P
    return out


def scan(motion, mode: Mode, onsets: list[Onset], z, R, dt, window, threshold, shortest):
    axes = motion.axes
    F, G = motion.F(mode.x, dt), motion.input_matrix(dt)
    onsets = [*onsets, Onset(np.zeros_like(G), np.zeros((axes, axes)), np.zeros(axes))][-window:]
    before = predict(motion, mode, dt)
    now = update(motion, before, z, R)
    there = ~np.isnan(z)
    H = measure_matrix(motion)[there]
    S_inverse = np.linalg.inv(now.S[np.ix_(there, there)])
    nu = now.residual[there]
    keep = np.eye(motion.n) - before.P @ H.T @ S_inverse @ H
    for each in onsets:
        moved = F @ each.M + G
        Psi = H @ moved
        each.M = keep @ moved
        each.Y = each.Y + Psi.T @ S_inverse @ Psi
        each.y = each.y + Psi.T @ S_inverse @ nu
    asked = onsets[: max(0, len(onsets) - shortest + 1)]
    if not asked:
        return now.mode, onsets, None
    best = asked[0]
    for each in asked[1:]:
        if each.significance > best.significance * (1 + 1e-9):
            best = each
    if not there.any() or best.significance <= threshold:
        return now.mode, onsets, None
    u, spread = np.linalg.solve(best.Y, best.y), np.linalg.inv(best.Y)
    return Mode(now.mode.x + best.M @ u, now.mode.P + best.M @ spread @ best.M.T), [], u
