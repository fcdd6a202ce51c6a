"""Filters on the "current" statistical model: fixed limits, fuzzy limits, and these beside constant velocity."""

from __future__ import annotations

from typing import Any

from ..filters.current_statistical import CurrentStatistical, FuzzyLimits
from ..filters.imm import IMM
from ..filters.kalman import Kalman
from ..models.motion import ConstantVelocity
from .interacting import STAYS
from .purpose import Named, Purpose

TIME_CONSTANT = 20.0  # s
# of the kind's acceleration: near its limit the model has next to no noise, so limits lie well above what targets do
LARGEST, THRESHOLD = 3.0, 4.0


def csaf(purpose: Purpose) -> Named:
    """Zhou's filter: accelerations up to three times the kind's."""
    a = purpose.acceleration
    motion: Any = CurrentStatistical(
        acceleration_max=LARGEST * a, time_constant=TIME_CONSTANT, acceleration_prior_sd=0.75 * a
    )
    words = f'"current" statistical filter, acceleration_max {LARGEST * a:g} m/s², time constant 20 s'
    return Named(filter=Kalman(motion, purpose.seen, outliers=purpose.outliers), words=words)


def facs(purpose: Purpose) -> Named:
    """The same with fuzzy limits that reach four times the kind's acceleration."""
    words = f'"current" statistical filter with fuzzy limits up to {THRESHOLD * purpose.acceleration:g} m/s²'
    motion: Any = fuzzy_limits(purpose)
    return Named(filter=Kalman(motion, purpose.seen, outliers=purpose.outliers), words=words)


def imm_facs(purpose: Purpose) -> Named:
    """IMM of constant velocity and the model of `facs`, mean stays as in `imm-cv-ca`."""
    a = purpose.acceleration
    modes: list[Any] = [ConstantVelocity(acceleration_psd=(a / 40) ** 2), fuzzy_limits(purpose)]
    return Named(
        filter=IMM(modes, purpose.seen, STAYS, outliers=purpose.outliers),
        words=f"IMM of CV and FACS, limits up to {THRESHOLD * a:g} m/s², mean stays 70 and 16 s",
    )


def fuzzy_limits(purpose: Purpose) -> CurrentStatistical:
    """The model of `facs`."""
    a = purpose.acceleration
    limits = FuzzyLimits(threshold=THRESHOLD * a, operating=0.9 * THRESHOLD * a)
    return CurrentStatistical(limits=limits, time_constant=TIME_CONSTANT, acceleration_prior_sd=0.75 * a)
