"""Filters that decide whether a manoeuvre is on: input estimation and variable dimension.

They watch for as long as the kind's acceleration needs to show: :attr:`Purpose.scans_to_show`.
"""

from __future__ import annotations

from ..filters.input_estimation import InputEstimation
from ..filters.variable_dimension import VariableDimension
from ..models.motion import ConstantAcceleration, ConstantVelocity
from .purpose import Named, Purpose

LONGEST = 64  # scans


def input_estimation(purpose: Purpose) -> Named:
    """Constant velocity as in the quiet mode of `imm-cv-ca`, corrected by accelerations that have had the time to
    show.
    """
    quiet = ConstantVelocity(acceleration_psd=(purpose.acceleration / 40) ** 2)
    shortest = min(purpose.scans_to_show, LONGEST // 2)
    filter = InputEstimation(quiet, purpose.seen, window=2 * shortest, shortest=shortest, outliers=purpose.outliers)
    words = f"constant velocity of acceleration_psd {quiet.acceleration_psd:g} m²/s³"
    return Named(filter=filter, words=f"input estimation, {words}, onsets {shortest} to {filter.window} scans ago")


def variable_dimension(purpose: Purpose) -> Named:
    """The quiet mode of `imm-cv-ca`, and an acceleration that may change by half the kind's over a manoeuvre of 16
    s.
    """
    a = purpose.acceleration
    quiet = ConstantVelocity(acceleration_psd=(a / 40) ** 2)
    manoeuvring = ConstantAcceleration(jerk_psd=(a / 8) ** 2, acceleration_prior_sd=a)
    filter = VariableDimension(
        quiet,
        manoeuvring,
        purpose.seen,
        window=min(purpose.scans_to_show + 1, LONGEST),
        false_alarm=0.01,
        outliers=purpose.outliers,
    )
    words = f"variable dimension, CV or CA of jerk_psd {manoeuvring.jerk_psd:.3g} m²/s⁵, window {filter.window} scans"
    return Named(filter=filter, words=words)
