"""Variable dimension: constant velocity until a manoeuvre is detected, then constant acceleration, begun in the past.

Bar-Shalom & Birmiwal, "Variable dimension filter for maneuvering target tracking", IEEE T-AES 18(5), 1982;
Bar-Shalom, Li & Kirubarajan 2001, 11.4. One track, z (N, axes), NaN where missing.

Detection: rho(k) = alpha rho(k-1) + nu' S^-1 nu, effective window s = 1/(1 - alpha) scans. Beyond the threshold
the target has manoeuvred since scan j = k - s: at j
    a = 2/T^2 (z - p - T v),  position = z,  velocity = v + T a,
from the quiet estimate [p v] at j - 1 and the step T between, with the covariance that z and that estimate
give them; then the constant-acceleration filter runs over j + 1 ... k again. It ends when the sum of a' P_a^-1 a
over the last s scans falls below its threshold; the accelerations are dropped.

Readings. A missing scan leaves rho as it is and nothing begins or ends at it; a detection whose scan j is missing
waits for the next scan. One is not gone back to before s + 2 quiet scans have passed since the start or the last
manoeuvre.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from oracle.many import predict, started, update
from oracle.mixture import Mode
from oracle.motion import AXES, ConstantAcceleration, ConstantVelocity

Array = NDArray[np.float64]


@dataclass
class Tracked:
    """x (N, 3 axes) = [p v a ...], a = 0 while quiet; P; manoeuvring (N,); begun (N,): scan gone back to, -1."""

    x: Array
    P: Array
    manoeuvring: NDArray[np.bool_]
    begun: NDArray[np.int_]


@dataclass
class Memory:
    """The quiet estimates and their number of scans, rho, and the significances while manoeuvring."""

    quiet: dict[int, Mode] = field(default_factory=dict)
    quiet_for: int = 0
    rho: float = 0.0
    manoeuvring: Mode | None = None
    significance: list[float] = field(default_factory=list)


def restarted(quiet: Mode, z: Array, R: Array, T: float, axes: int) -> Mode:
    """[p v a] per axis from the quiet estimate one step before and z; errors (n, e) of z and the estimate."""
    to_z, to_x = np.zeros((3 * axes, axes)), np.zeros((3 * axes, 2 * axes))
    for a in range(axes):
        p, v, acc = 3 * a, 3 * a + 1, 3 * a + 2
        to_z[p, a] = 1
        to_z[acc, a], to_x[acc, 2 * a], to_x[acc, 2 * a + 1] = 2 / T**2, -2 / T**2, -2 / T
        to_z[v, a] = T * to_z[acc, a]
        to_x[v] = T * to_x[acc]
        to_x[v, 2 * a + 1] += 1
    return Mode(to_z @ z + to_x @ quiet.x, to_z @ R @ to_z.T + to_x @ quiet.P @ to_x.T)


def where(axes: int, letters: str) -> list[int]:
    return [3 * a + "pva".index(letter) for a in range(axes) for letter in letters]


class VariableDimension:
    def __init__(
        self,
        quiet: ConstantVelocity,
        active: ConstantAcceleration,
        R: Array,
        window: int,
        threshold: float,
        back_threshold: float,
    ):
        self.quiet, self.active, self.R = quiet, active, R
        self.window, self.alpha = window, 1 - 1 / window
        self.threshold, self.back_threshold = threshold, back_threshold

    def track(self, time: Array, z: Array) -> Tracked:
        N, axes = z.shape
        n = 3 * axes
        out = Tracked(np.full((N, n), np.nan), np.full((N, n, n), np.nan), np.zeros(N, bool), np.full(N, -1))
        start = started([self.quiet], time, z[None, :2], self.R)[0]
        memory = Memory({1: Mode(start.x[0], start.P[0])})
        self.write(out, 1, memory)
        for k in range(2, N):
            if memory.manoeuvring is None:
                out.begun[k] = self.quiet_scan(memory, time, z, k)
            else:
                self.active_scan(memory, time, z, k)
            self.write(out, k, memory)
        return out

    def quiet_scan(self, memory: Memory, time: Array, z: Array, k: int) -> int:
        """One scan of constant velocity; on detection the scan gone back to, else -1."""
        now = update(self.quiet, predict(self.quiet, memory.quiet[k - 1], time[k] - time[k - 1]), z[k], self.R)
        memory.quiet[k] = now.mode
        memory.quiet_for += 1
        measured = not np.isnan(z[k]).all()
        if measured:
            memory.rho = self.alpha * memory.rho + now.residual @ np.linalg.solve(now.S, now.residual)
        j = k - self.window
        known = memory.quiet_for >= self.window + 2 and not np.isnan(z[j]).any()
        if not measured or memory.rho <= self.threshold or not known:
            return -1
        mode = restarted(memory.quiet[j - 1], z[j], self.R, time[j] - time[j - 1], self.quiet.axes)
        for i in range(j + 1, k + 1):
            mode = update(self.active, predict(self.active, mode, time[i] - time[i - 1]), z[i], self.R).mode
        memory.manoeuvring, memory.significance = mode, []
        return j

    def active_scan(self, memory: Memory, time: Array, z: Array, k: int) -> None:
        before = predict(self.active, memory.manoeuvring, time[k] - time[k - 1])
        mode = memory.manoeuvring = update(self.active, before, z[k], self.R).mode
        at = where(self.active.axes, "a")
        memory.significance.append(float(mode.x[at] @ np.linalg.solve(mode.P[np.ix_(at, at)], mode.x[at])))
        last = memory.significance[-self.window :]
        measured = not np.isnan(z[k]).all()
        if measured and len(last) == self.window and sum(last) < self.back_threshold:
            kept = where(self.active.axes, "pv")
            memory.quiet_for, memory.quiet = 0, {k: Mode(mode.x[kept], mode.P[np.ix_(kept, kept)])}
            memory.manoeuvring, memory.rho = None, 0.0

    def write(self, out: Tracked, k: int, memory: Memory) -> None:
        if memory.manoeuvring is not None:
            out.x[k], out.P[k], out.manoeuvring[k] = memory.manoeuvring.x, memory.manoeuvring.P, True
            return
        at, mode = where(len(AXES[: self.quiet.axes]), "pv"), memory.quiet[k]
        out.x[k], out.P[k] = 0.0, 0.0
        out.x[k, at] = mode.x
        out.P[k][np.ix_(at, at)] = mode.P
