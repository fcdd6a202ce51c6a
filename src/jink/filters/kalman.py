"""The Kalman filter: one motion model."""

from collections.abc import Sequence
from typing import Literal

from ..models.motion import NativeMotion, OwnMotion
from ..models.outliers import Outliers
from ..models.sensor import OwnSensor, Sensor
from ..models.start import OnePoint, Prior, TwoPoint
from .bank import Bank
from .plain import LINEARISED


class Kalman(Bank):
    """Kalman filter; extended (or unscented) where the motion or the sensor is not linear.

    x⁻ = f(x), P⁻ = F P Fᵀ + Q;  S = H P⁻ Hᵀ + R, K = P⁻ Hᵀ S⁻¹, x = x⁻ + K (z − h(x⁻)), P = (I − K H) P⁻

    motion one of :mod:`jink.models.motion` or your own; sensor one or several of :mod:`jink.models.sensor`;
    linearisation "ekf" or "ukf"; outliers None or :class:`jink.Outliers`; initial :class:`jink.TwoPoint`, OnePoint or
    Prior; coast (s) without an accepted measurement after which a track ends and the next measurement starts it anew.
    Source: Kalman 1960; Bar-Shalom, Li & Kirubarajan 2001, §5.2, §10.3; unscented: Julier & Uhlmann, Proc. IEEE 92(3),
    2004.
    """

    arguments = LINEARISED

    def __init__(
        self,
        motion: NativeMotion | OwnMotion,
        sensor: Sensor | OwnSensor | Sequence[Sensor | OwnSensor],
        *,
        linearisation: Literal["ekf", "ukf"] = "ekf",
        outliers: Outliers | None = None,
        initial: TwoPoint | OnePoint | Prior | None = None,
        coast: float | None = None,
    ) -> None:
        self._declare((motion,), sensor, outliers, initial, coast)
        self.linearisation = linearisation
        self._prepare(linearisation=linearisation, coast=coast)

    def __repr__(self) -> str:
        return f"Kalman({self.motions[0]!r}, {', '.join(map(repr, self.sensors))})"
