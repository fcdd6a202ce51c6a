"""How a truth is seen: a sensor of `jink.models.sensor` with misses, gross outliers and bias, and when it looks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..checks import Array, number, numbers, positive, real, whole
from ..frozen import frozen
from ..metrics.draws import Draws
from ..models.sensor import SENSORS, Polar, Sensor
from .truth import Kinematics

MOST_SCANS = 10**8  # of one run


@frozen(kw_only=True)
class Schedule:
    """Scan k at start + k · interval + a uniform jitter of ± jitter, k = 0 … count − 1; seconds."""

    start: float = 1.0
    interval: float = 1.0
    count: int = 180
    jitter: float = 0.0

    def __post_init__(self) -> None:
        positive("interval", self.interval)
        number("start", self.start)
        whole("count", self.count, 1, MOST_SCANS, of=" of scans")
        if not 0 <= real("jitter", self.jitter) < self.interval / 2:
            raise ValueError(
                f"jitter: expected 0 to below half the interval of {self.interval:g} s, got {self.jitter:g}"
            )

    @property
    def end(self) -> float:
        """Nominal time of the last scan."""
        return self.start + (self.count - 1) * self.interval

    def every(self, interval: float, jitter: float = 0.0) -> Schedule:
        """The same stretch of time with another revisit interval."""
        count = int(np.floor((self.end - self.start) / positive("interval", interval) + 1e-9)) + 1
        return replace(self, interval=interval, count=count, jitter=jitter)

    def times(self, draws: Draws) -> Array:
        """(B, S), or (1, S) when all runs share the times; never before the truth begins at 0."""
        nominal = self.start + self.interval * np.arange(self.count, dtype=np.float64)[None, :]
        jitter = draws.uniform(-self.jitter, self.jitter, self.count) if self.jitter else 0.0
        return np.maximum(nominal + jitter, 0.0)


@frozen(kw_only=True)
class Observation:
    """z = h(truth) + bias + v, v ~ N(0, R); missing with probability 1 − detection; some gross outliers.

    sensor one of those of :mod:`jink.models.sensor`; detection probability per scan; outlier_share of
    the scans have outlier_scale times the noise (a contaminated normal, Huber 1964); bias one number per
    component, in its unit. A sensor of more axes than the truth sees it at height 0; one of fewer sees its
    projection to the plane.
    """

    sensor: Sensor
    detection: float = 1.0
    outlier_share: float = 0.0
    outlier_scale: float = 20.0
    bias: Sequence[float] = ()

    def __post_init__(self) -> None:
        if not hasattr(self.sensor, "observe"):
            raise TypeError(f"sensor: expected one of {', '.join(SENSORS)}, got {self.sensor!r}")
        if not 0 < real("detection", self.detection) <= 1:
            raise ValueError(f"detection: expected a probability above 0 and up to 1, got {self.detection!r}")
        if not 0 <= real("outlier_share", self.outlier_share) < 1:
            raise ValueError(f"outlier_share: expected a share from 0 to below 1, got {self.outlier_share!r}")
        positive("outlier_scale", self.outlier_scale)
        bias = numbers("bias", self.bias)
        if bias.ndim != 1 or bias.size not in (0, len(self.components)):
            names = ", ".join(self.components)
            raise ValueError(f"bias: expected one number for each of {names}, got {bias.size}")

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the columns of z."""
        return self.sensor.components

    def measure(self, truth: Kinematics, seed: int, runs: np.ndarray) -> Array:
        """z (B, S, m) of kinematics (B, S, axes); NaN where the target was missed."""
        z = self.sensor.observe(truth)
        scans, m = z.shape[1:]
        noise = Draws(seed, runs, "noise").normal(scans, m) @ np.linalg.cholesky(self.sensor.noise).T
        if self.outlier_share:
            gross = Draws(seed, runs, "outliers").uniform(0, 1, scans) < self.outlier_share
            noise *= np.where(gross, self.outlier_scale, 1.0)[..., None]
        z = z + noise
        if len(self.bias):
            z += np.asarray(self.bias, dtype=float)
        for column, name in enumerate(self.components):
            if name == "azimuth":
                z[..., column] = np.remainder(z[..., column] + np.pi, 2 * np.pi) - np.pi
            if name == "range":
                z[..., column] = np.abs(z[..., column])
        if self.detection < 1:
            z[Draws(seed, runs, "detection").uniform(0, 1, scans) >= self.detection] = np.nan
        return z


# radars to combine with any scenario: the observation, its revisit interval and jitter (s)
RADARS: dict[str, tuple[Observation, float, float]] = {
    "radar-20hz": (
        Observation(sensor=Polar(range_sd=25.0, azimuth_sd=2e-3, elevation_sd=2e-3, range_rate_sd=1.0)),
        0.05,
        0.0,
    ),
    "radar-1hz": (Observation(sensor=Polar(range_sd=25.0, azimuth_sd=2e-3, elevation_sd=2e-3)), 1.0, 0.0),
    "radar-4s": (Observation(sensor=Polar(range_sd=50.0, azimuth_sd=1.4e-3, height_sd=8.0)), 4.0, 0.05),
    "radar-12s": (Observation(sensor=Polar(range_sd=70.0, azimuth_sd=1.4e-3, height_sd=8.0)), 12.0, 0.1),
}
