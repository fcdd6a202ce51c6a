"""The Kalman filter: one motion model."""

from collections.abc import Sequence
from typing import Literal

from ..motion import NativeMotion, OwnMotion
from ..noise import OnePoint, Outliers, Prior, TwoPoint
from ..sensor import OwnSensor, Sensor
from .bank import Bank


class Kalman(Bank):
    """Kalman filter; extended (or unscented) where the motion or the sensor is not linear.

    x⁻ = f(x), P⁻ = F P Fᵀ + Q;  S = H P⁻ Hᵀ + R, K = P⁻ Hᵀ S⁻¹, x = x⁻ + K (z − h(x⁻)), P = (I − K H) P⁻

    motion one of :mod:`jink.motion` or your own; sensor one or several of :mod:`jink.sensor`; linearisation "ekf" or "ukf";
    outliers None or :class:`jink.Outliers`; initial :class:`jink.TwoPoint`, OnePoint or Prior; coast (s) without an accepted
    measurement after which a track ends and the next measurement starts it anew.
    Source: Kalman 1960; Bar-Shalom, Li & Kirubarajan 2001, §5.2, §10.3; unscented: Julier & Uhlmann, Proc. IEEE 92(3), 2004.
    """

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
