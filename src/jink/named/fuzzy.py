"""Filters whose process noise comes from fuzzy rules: the published IMM of lee-2003, scaled, and a single filter."""

from __future__ import annotations

from typing import Any

from ..filters.fuzzy_imm import FuzzyNoise, fuzzy_imm
from ..filters.kalman import Kalman
from ..fuzzy import PUBLISHED, FuzzyRules
from ..motion import ConstantVelocity
from .purpose import Named, Purpose

SD, ACCELERATION = 500.0, 40.0  # m, m/s²: what the published rules were identified for
STAY = 0.97  # from one interval to the next


def published_imm(purpose: Purpose) -> Named:
    """The published rules, residuals in proportion to the sensor's sd, variances to the kind's acceleration squared."""
    length, level = purpose.position_sd / SD, (purpose.acceleration / ACCELERATION) ** 2
    rules = [scaled(table, length, level) for table in PUBLISHED["lee-2003"]]
    filter = fuzzy_imm(
        purpose.seen, rules, purpose.staying(STAY, len(rules)), outliers=purpose.outliers
    )
    return Named(filter=filter, words=f"fuzzy IMM, {_words(length, level)}, stay {STAY:g} per interval")


def kalman(purpose: Purpose) -> Named:
    """One constant velocity whose noise is low where the residual is within two sd, high where it is beyond three."""
    sd, a = purpose.position_sd, purpose.acceleration
    low, high = (a / 40) ** 2, a * a
    rows = [(0.0, sd, 0.0, 2 * sd, low)]
    rows += [(side * 3.5 * sd, sd, 0.0, 4 * sd, high) for side in (-1.0, 1.0)]
    motion: Any = FuzzyNoise(ConstantVelocity(acceleration_sd=a / 4), FuzzyRules.of(rows, unit=1.0))
    words = f"constant velocity, acceleration sd by three rules from {a / 40:g} m/s² (residual near 0) to {a:g} m/s² (beyond 3 sd)"
    return Named(filter=Kalman(motion, purpose.seen, outliers=purpose.outliers), words=words)


def scaled(rules: FuzzyRules, length: float, level: float) -> FuzzyRules:
    """Residuals times ``length``, variances times ``level``."""
    scaled_ = [(c1 * length, s1 * length, c2 * length, s2 * length, w * level) for c1, s1, c2, s2, w in rules.table()]
    return FuzzyRules.of(scaled_, unit=1.0)


def _words(length: float, level: float) -> str:
    if abs(length - 1.0) < 1e-12 and abs(level - 1.0) < 1e-12:
        return "published rules of lee-2003"
    return f"published rules of lee-2003 with residuals times {length:.3g} and variances times {level:.3g}"
