"""A target that coasts: after some seconds without an accepted measurement it ceases to manoeuvre and to climb.

Means alone change. Accelerations and turn rates die away by a' = -a / manoeuvre, climb rates by v' = -v / climb, from
the moment on at which the target is said to coast. One that does not go backwards stands still where it would turn
about.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oracle.gaussian import parts
from oracle.motion import Motion

Array = NDArray[np.float64]


@dataclass
class Coasting:
    after: float
    manoeuvre: float
    climb: float
    reverses: bool = True


def coasted(
    c: Coasting, motion: Motion, x: Array, predicted: Array, dt: float, late: float, late_height: float
) -> Array:
    """The prediction of x over dt, of which the last `late` seconds are coasting, and `late_height` for the height."""
    y = predicted.copy()
    position, velocity = parts(motion)
    names = motion.components
    if "ax" in names:
        for axis, (p, v) in enumerate(zip(position, velocity, strict=True)):
            since = late_height if axis == 2 else late
            if since > 0:
                y[[p, v, v + 1]] = eased(c, *x[[p, v, v + 1]], dt - since, since)
        if not c.reverses and motion.axes > 1:
            stop(x, y, position[:2], velocity[:2])
    elif motion.turning and late > 0:
        kept = np.exp(-late / c.manoeuvre)
        angle = x[-1] * (dt - late + c.manoeuvre * (1 - kept))
        vx, vy = x[velocity[:2]]
        s, cos = np.sinc(angle / np.pi), (1 - np.cos(angle)) / angle if angle else 0.0
        y[position[:2]] = x[position[:2]] + dt * np.array([s * vx - cos * vy, cos * vx + s * vy])
        y[velocity[:2]] = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ [vx, vy]
        y[-1] = kept * x[-1]
    if motion.axes == 3 and late_height > 0:
        p, v = position[2], velocity[2]
        kept = np.exp(-late_height / c.climb)
        y[p] += (c.climb * (1 - kept) - late_height) * y[v]
        y[v] *= kept
    return y


def eased(c: Coasting, p: float, v: float, a: float, early: float, late: float) -> tuple[float, float, float]:
    """[p v a] after `early` seconds as before and `late` seconds of a' = -a / manoeuvre."""
    p, v = p + early * v + 0.5 * early**2 * a, v + early * a
    tau = c.manoeuvre
    kept = np.exp(-late / tau)
    return p + late * v + tau * (late - tau * (1 - kept)) * a, v + tau * (1 - kept) * a, kept * a


def stop(x: Array, y: Array, position: list[int], velocity: list[int]) -> None:
    """Stand still, in place, where the velocity of the prediction points backwards."""
    v, a = x[velocity], x[[k + 1 for k in velocity]]
    if v @ y[velocity] < 0:
        until = (v @ v) / -(v @ a)
        y[position] = x[position] + until * v + 0.5 * until**2 * a
        y[velocity] = y[[k + 1 for k in velocity]] = 0.0
