"""FACS with limits along and across the velocity, and limits that widen where a position is a surprise.

D (axes, axes) is the variance that limits leave, Q = D (x) 2 alpha Q0. Per axis D = diag(sigma_a^2). Along and
across the velocity v, of direction e: D = sigma_across^2 I + s (sigma_along^2 - sigma_across^2) e e',
s = |v|^2 / (|v|^2 + tr P_v); a_along = e a, a_across = |a - (e a) e|. Widened: w = (NIS - 1)/(nis - 1) between 0 and 1
takes sigma^2 towards (4 - pi)/pi (times a_th + |a|)^2, NIS the squared residual over its variance along each direction.
"""

from __future__ import annotations

import numpy as np

from oracle.current_statistical import RAYLEIGH, FuzzyCurrentStatistical
from oracle.motion import singer_exact


class SurprisedStatistical(FuzzyCurrentStatistical):
    """along (across is None: each axis) is what the parent is declared with; across another such model."""

    name = "current_statistical"

    def __init__(self, axes, time_constant, across=None, nis=None, times=None, **given):
        super().__init__(axes, time_constant, **given)
        self.across, self.nis, self.times = across, nis, times

    def seen_noise(self, before, z, R, dt):
        """Q (B, n, n) of a scan with the positions z, `before` predicted without noise."""
        tau = float(self.time_constant[0])
        Q0 = 2 / tau * singer_exact(float(dt), tau)[1]
        return np.array(
            [
                np.kron(self.spread(x, P, position, R, Q0[0, 0]), Q0)
                for x, P, position in zip(before.x, before.P, z, strict=True)
            ]
        )

    def spread(self, x, P, z, R, unit):
        """D of one track. Reading: a position that is not complete is a miss to the limits (the update uses it)."""
        z = np.where(np.isnan(z).any(), np.nan, z)
        v, a, residual, S = x[1::3], x[2::3], z - x[::3], P[::3, ::3] + R
        if self.across is None:
            return np.diag(
                [self.widened(self, a[i], residual[i] ** 2, S[i, i], 1, unit) for i in range(self.axes)],
            )
        e = v / np.linalg.norm(v)
        others = np.eye(self.axes) - np.outer(e, e)
        first = self.widened(self, e @ a, (e @ residual) ** 2, e @ S @ e, 1, unit)
        if self.axes == 1:
            return np.array([[first]])
        second = self.widened(
            self.across,
            np.linalg.norm(others @ a),
            residual @ others @ residual,
            np.trace(others @ S @ others),
            self.axes - 1,
            unit,
        )
        share = v @ v / (v @ v + np.trace(P[1::3, 1::3]))
        return second * np.eye(self.axes) + share * (first - second) * np.outer(e, e)

    def widened(self, limits, a, square, S, dof, unit):
        """sigma^2 in one direction, or in dof of them alike."""
        quiet = float(limits.variance(np.array(a)))
        if self.nis is None or np.isnan(square):
            return quiet
        nis = square / (S + dof * unit * quiet)
        share = np.clip((nis - 1) / (self.nis - 1), 0, 1)
        most = limits.upper if a >= 0 else -limits.lower
        wide = RAYLEIGH * (self.times * most + abs(a)) ** 2
        return quiet + share * max(wide - quiet, 0.0)
