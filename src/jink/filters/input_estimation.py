"""Input estimation: a Kalman filter that estimates an acceleration from its innovations and corrects itself by it."""

from __future__ import annotations

from .._engine import native
from ..checks import rare, whole
from ..models.motion import AnyMotion
from ..models.outliers import Outliers
from ..models.sensor import Sensor
from ..models.start import OnePoint, Prior, TwoPoint
from .bank import Bank
from .parts import Parts
from .plain import COMMON


class InputEstimation(Bank):
    """Kalman filter with a manoeuvre detector that estimates a constant acceleration over a sliding window.

    For each onset ``shortest`` to ``window`` scans ago: M ← (I − K H)(F M + G), Ψ = H (F M + G), Y += Ψᵀ S⁻¹ Ψ, y += Ψᵀ
    S⁻¹ ν. If the largest yᵀ Y⁻¹ y exceeds χ²(axes) at ``false_alarm``, u = Y⁻¹ y: x += M u, P += M Y⁻¹ Mᵀ, and the
    watch begins anew.

    motion without acceleration, linear; shortest (default half the window): an acceleration that explains one or two
    innovations only is mostly noise; false_alarm the probability of a correction without a manoeuvre, per onset and
    scan. Source: Chan, Hu & Plant, IEEE Trans. AES-15(2), 1979; over all onsets of a window: Bogler, IEEE Trans.
    AES-23(3), 1987.
    """

    arguments = ("window", "shortest", "false_alarm", *COMMON)

    not_smoothed = "its corrections belong to no motion model; smooth a jink.IMM with a mode that accelerates"

    def __init__(
        self,
        motion: AnyMotion,
        sensor: Sensor,
        *,
        window: int = 8,
        shortest: int | None = None,
        false_alarm: float = 1e-3,
        outliers: Outliers | None = None,
        initial: TwoPoint | OnePoint | Prior | None = None,
        coast: float | None = None,
    ) -> None:
        self._declare((motion,), sensor, outliers, initial, coast)
        self.window, self.shortest, self.false_alarm = window, shortest, false_alarm
        if getattr(motion, "name", "") != "constant_velocity":
            raise ValueError(f"motion: expected a ConstantVelocity, got {type(motion).__name__}")
        length = whole("window", window, 1, 64, " of scans")
        least = max(1, length // 2) if shortest is None else whole("shortest", shortest, 1, length, " of scans")
        from ..metrics.chi_square import quantile

        threshold = quantile(1 - rare("false_alarm", false_alarm), self.axes)
        self._prepare(
            coast=coast, parts=Parts(detection=native.Detection(window=length, shortest=least, threshold=threshold))
        )

    def __repr__(self) -> str:
        return f"InputEstimation({self.motions[0]!r}, {', '.join(map(repr, self.sensors))}, window={self.window})"
