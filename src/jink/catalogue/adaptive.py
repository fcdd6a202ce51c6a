"""Acceleration estimated as a bias, and the adaptive IMM around it.

The estimate that an adaptive IMM takes is run as in lee-2003, with a bias noise of a quarter of the kind's acceleration
per scan; by itself, where that would leave hardly more than the measurements, with a tenth. Its modes have a tenth of
it as noise, so that accelerations between the levels are theirs as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..filters.adaptive_imm import AugmentedAcceleration, TwoStageAcceleration, aimm
from ..filters.kalman import Kalman
from .purpose import Named, Purpose

STAY = 0.97  # from one interval to the next


def two_stage(purpose: Purpose) -> Named:
    """The two-stage estimator: bias noise a tenth of the kind's acceleration per scan."""
    return _single(purpose, TwoStageAcceleration(**_noises(purpose, 1 / 10)), "two-stage estimator")


def augmented(purpose: Purpose) -> Named:
    """The optimal filter of the same model."""
    return _single(purpose, AugmentedAcceleration(**_noises(purpose, 1 / 10)), "augmented-state filter")


def aimm3(purpose: Purpose) -> Named:
    """Adaptive IMM: the estimate, and the kind's acceleration to either side along each axis."""
    return _aimm(purpose, [1.0])


def aimm5(purpose: Purpose) -> Named:
    """Adaptive IMM: the estimate, half the kind's acceleration and all of it to either side along each axis."""
    return _aimm(purpose, [0.5, 1.0])


def _noises(purpose: Purpose, bias: float) -> dict[str, float]:
    a = purpose.acceleration
    return {"acceleration_sd": a / 40, "bias_sd": bias * a, "bias_prior_sd": 0.79 * a}


def _single(purpose: Purpose, motion: Any, what: str) -> Named:
    words = f"{what}, acceleration changing by {motion.bias_sd:g} m/s² per scan"
    return Named(filter=Kalman(motion, purpose.seen, outliers=purpose.outliers), words=words)


def _aimm(purpose: Purpose, steps: Sequence[float]) -> Named:
    a, sensor = purpose.acceleration, purpose.seen
    right = [step * a for step in steps]
    axes = int(getattr(sensor, "axes", None) or 2)
    levels = [*(-level for level in reversed(right)), 0.0, *right]
    modes = 1 + 2 * len(right) * axes
    filter = aimm(
        levels,
        sensor,
        purpose.staying(STAY, modes),
        acceleration_sd=a / 10,
        estimator=TwoStageAcceleration(**_noises(purpose, 1 / 4)),
        outliers=purpose.outliers,
    )
    along = "along each axis " if axes > 1 else ""
    apart = " and ".join(f"±{level:g}" for level in right)
    return Named(
        filter=filter,
        words=f"adaptive IMM of {modes} modes, {along}{apart} m/s² around a two-stage estimate, stay {STAY:g} per "
        "interval",
    )
