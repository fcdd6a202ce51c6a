"""Filters with one motion model: constant velocity and acceleration, their noise tuned where it can be, and
Singer's.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from ..filters.kalman import Kalman
from ..models.motion import ConstantAcceleration, ConstantVelocity, Motion, Singer
from .purpose import Named, Purpose
from .tuning import best_noise


def kalman_cv(purpose: Purpose) -> Named:
    """Constant velocity: the best noise for this purpose; without data to tell, the kind's acceleration."""
    if purpose.loss is None:
        sd = purpose.acceleration
        motion = ConstantVelocity(acceleration_sd=sd)
        return _kalman(purpose, motion, f"constant velocity, acceleration_sd {sd:g} m/s²")
    return _tuned(
        purpose,
        lambda q: ConstantVelocity(acceleration_psd=q),
        lambda q: f"constant velocity, acceleration_psd {q:.3g} m²/s³",
        3,
    )


def kalman_ca(purpose: Purpose) -> Named:
    """Constant acceleration: the best noise for this purpose; without data to tell, one of the kind's."""
    a = purpose.acceleration
    if purpose.loss is None:
        motion = ConstantAcceleration(jerk_psd=a * a / 10.0, acceleration_prior_sd=a)
        return _kalman(purpose, motion, f"constant acceleration, jerk_psd {a * a / 10.0:.3g} m²/s⁵")
    return _tuned(
        purpose,
        lambda q: ConstantAcceleration(jerk_psd=q, acceleration_prior_sd=a),
        lambda q: f"constant acceleration, jerk_psd {q:.3g} m²/s⁵",
        5,
    )


def singer(purpose: Purpose) -> Named:
    """Singer's filter with half the kind's acceleration as sd and a time constant of 20 s, not fitted."""
    motion = Singer(acceleration_sd=0.5 * purpose.acceleration, time_constant=20.0)
    words = f"Singer, acceleration_sd {motion.acceleration_sd:g} m/s², time_constant 20 s"
    return Named(filter=_made(purpose, motion), words=words)


def _kalman(purpose: Purpose, motion: Motion, words: str, fitted: str = "") -> Named:
    return Named(filter=_made(purpose, motion), words=f"Kalman filter, {words}", fitted=fitted)


def _made(purpose: Purpose, motion: Motion) -> Kalman:
    return Kalman(motion, purpose.seen, outliers=purpose.outliers)


def _tuned(purpose: Purpose, motion: Callable[[float], Any], words: Callable[[float], str], power: int) -> Named:
    """The noise between 1e-8 and 1e4 of sd²/T^power with the least loss; scans quicker than one a second do not raise
    the lower end, since targets do not manoeuvre more quickly for being seen more often.
    """
    loss = purpose.loss
    assert loss is not None
    low, high = (purpose.sd**2 / T**power for T in (max(purpose.interval, 1.0), purpose.interval))
    looks = 10 + round(math.log(high / low) / math.log(20.0))
    noise = best_noise(lambda q: loss(_made(purpose, motion(q))), 1e-8 * low, 1e4 * high, looks=looks)
    return _kalman(purpose, motion(noise), words(noise), purpose.fitted)
