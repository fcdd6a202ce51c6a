"""The variable-dimension filter: constant velocity, and constant acceleration while a manoeuvre lasts."""

from __future__ import annotations

from typing import Any

import numpy as np

from .._engine import native
from ..checks import rare, whole
from ..models.motion import ConstantAcceleration, ConstantVelocity
from ..models.outliers import Outliers
from ..models.sensor import Sensor
from ..models.start import OnePoint, Prior, TwoPoint
from .bank import Bank
from .parts import Parts
from .plain import COMMON


class VariableDimension(Bank):
    """Two filters of which one is in use, and detectors that switch between them.

    Quiet: ρ ← (1 − 1/W) ρ + νᵀS⁻¹ν; above its threshold a manoeuvre began W scans ago, and the filter with acceleration
    starts there, a = 2/T² (z − p − T v), and runs over the measurements since. Manoeuvring: the sum of aᵀ P_aa⁻¹ a over
    the last W scans; below its threshold the target flies straight again. ρ is taken as χ² with its mean and variance,
    the sum as χ²(W · axes).

    quiet, manoeuvring the two motion models; window W (scans); false_alarm the probability that a quiet ρ exceeds its
    threshold, missed_end that the acceleration's sum does though there is none. Source: Bar-Shalom & Birmiwal, IEEE
    Trans. AES-18(5), 1982.
    """

    arguments = ("window", "false_alarm", "missed_end", *COMMON)

    not_smoothed = "it switches between motion models by a hard decision; smooth a jink.IMM of the two"

    def __init__(
        self,
        quiet: ConstantVelocity,
        manoeuvring: ConstantAcceleration,
        sensor: Sensor,
        *,
        window: int = 5,
        false_alarm: float = 1e-3,
        missed_end: float = 0.05,
        outliers: Outliers | None = None,
        initial: TwoPoint | OnePoint | Prior | None = None,
        coast: float | None = None,
    ) -> None:
        for part, motion, kind in (
            ("quiet", quiet, ConstantVelocity),
            ("manoeuvring", manoeuvring, ConstantAcceleration),
        ):
            if not isinstance(motion, kind):
                raise TypeError(f"{part}: expected a {kind.__name__}, got {type(motion).__name__}")
        self._declare((quiet, manoeuvring), sensor, outliers, initial, coast)
        self.window, self.false_alarm, self.missed_end = window, false_alarm, missed_end
        whole("window", window, 2, 64, " of scans")
        rare("false_alarm", false_alarm)
        rare("missed_end", missed_end)
        proposal = native.Proposal(
            kind=native.Propose.dimension, slots=2, start=[0.0, -1.0], numbers=self._thresholds()
        )
        parts: Any = Parts(interaction=native.Interaction.none, proposal=proposal, start=np.array([1.0, 0.0]))
        self._prepare(transition=0.5, coast=coast, parts=parts)

    def _thresholds(self) -> list[float]:
        from ..metrics.chi_square import quantile, wilson_hilferty

        W, m = int(self.window), self.axes
        keep = 1 - 1 / W
        mean, variance = m / (1 - keep), 2 * m / (1 - keep**2)  # of the fading sum of χ²(m)
        scale, freedom = variance / (2 * mean), 2 * mean**2 / variance
        rise = scale * wilson_hilferty(1 - self.false_alarm, freedom)
        return [float(W), rise, quantile(1 - self.missed_end, W * m)]

    def __repr__(self) -> str:
        return f"VariableDimension({', '.join(map(repr, self.motions))}, {', '.join(map(repr, self.sensors))}, "
        f"window={self.window})"
