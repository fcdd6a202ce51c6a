"""Filters that decide whether a manoeuvre is on: input estimation and variable dimension."""

from __future__ import annotations

from typing import Any

from ..filters.input_estimation import InputEstimation
from ..filters.variable_dimension import VariableDimension
from ..motion import ConstantVelocity
from .interacting import cv_and_ca
from .purpose import Named, Purpose


def input_estimation(purpose: Purpose) -> Named:
    """Constant velocity with the noise of the quiet mode of `imm-cv-ca`, corrected by the accelerations found."""
    quiet = ConstantVelocity(acceleration_psd=(purpose.acceleration / 40) ** 2)
    filter = InputEstimation(quiet, purpose.seen, outliers=purpose.outliers)
    return Named(
        filter=filter,
        words=f"input estimation, constant velocity of acceleration_psd {quiet.acceleration_psd:g} m²/s³, window {filter.window} scans",
    )


def variable_dimension(purpose: Purpose) -> Named:
    """The modes of `imm-cv-ca`, one at a time."""
    quiet, manoeuvring = cv_and_ca(purpose)
    one: Any = quiet
    other: Any = manoeuvring
    filter = VariableDimension(one, other, purpose.seen, outliers=purpose.outliers)
    words = f"variable dimension, CV or CA as in imm-cv-ca, window {filter.window} scans"
    return Named(filter=filter, words=words)
