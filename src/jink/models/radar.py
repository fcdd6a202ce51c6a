"""How a sensor sees a sky of many targets: what it detects, what it sees that is not there, where and how often."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, pi

import numpy as np

from ..checks import PerAxis, numbers, positive, probability
from ..frozen import frozen
from .sensor import Polar, Position, Sensor


@frozen(kw_only=True)
class Radar:
    """A sensor whose plots have no names.

    What is measured is ``sd`` (m, positions), or ``range_sd`` (m) and ``azimuth_sd`` (rad) from ``site``, or any
    ``sensor`` of :mod:`jink.models.sensor`; the filter's own sensor if none is given. detection: probability that a
    target is seen in a scan. clutter_per_scan: false plots, None: learned from the plots. What is given is corrected by
    the plots too, unless learn_clutter=False. So is the detection probability, where the share of scans in which sure
    tracks have a plot contradicts it by three standard errors, unless learn_detection=False. area: (x from, x to,
    y from, y to) in m, or ``reach`` (m) around the site: what the sensor looks at; None: where its plots are. height
    (m) and fastest (m/s): how far false heights and speeds spread, where those are measured. period (s): of a scan.
    scanning=False: reports come when they come (ADS-B), so that none is missed.
    Errors: ValueError naming what makes no sense.
    """

    sd: PerAxis | None = None
    range_sd: float | None = None
    azimuth_sd: float | None = None
    sensor: Sensor | None = None
    site: Sequence[float] = (0.0, 0.0)
    detection: float = 0.9
    clutter_per_scan: float | None = None
    period: float | None = None
    area: Sequence[float] | None = None
    reach: float | None = None
    height: float = 12_000.0
    fastest: float = 300.0
    scanning: bool = True
    learn_clutter: bool = True
    learn_detection: bool = True
    name: str = "radar"

    def __post_init__(self) -> None:
        probability("Radar.detection", self.detection)
        if self.clutter_per_scan is not None:
            positive("Radar.clutter_per_scan", self.clutter_per_scan, zero=True)
        if self.period is not None:
            positive("Radar.period", self.period)
        if self.reach is not None:
            positive("Radar.reach", self.reach)
        positive("Radar.height", self.height)
        positive("Radar.fastest", self.fastest)
        if self.area is not None:
            a = numbers("Radar.area", self.area).reshape(-1).tolist()
            if len(a) != 4 or not np.all(np.isfinite(a)) or not (a[0] < a[1] and a[2] < a[3]):
                raise ValueError(f"Radar.area: expected (x from, x to, y from, y to) in metres, got {self.area!r}")
        polar = self.range_sd is not None or self.azimuth_sd is not None
        if (self.sd is not None) + polar + (self.sensor is not None) > 1:
            raise ValueError("Radar: give one of sd, range_sd with azimuth_sd, and sensor")
        if polar and (self.range_sd is None or self.azimuth_sd is None):
            raise ValueError("Radar: expected both range_sd and azimuth_sd")
        self.measures()

    def measures(self) -> Sensor | None:
        """The sensor model, or None where the filter's own counts."""
        if self.sd is not None:
            return Position(sd=self.sd)
        if self.range_sd is not None and self.azimuth_sd is not None:
            return Polar(range_sd=self.range_sd, azimuth_sd=self.azimuth_sd, site=self.site, method="converted")
        return self.sensor

    def size(self) -> float | None:
        """The declared area (m²), or None."""
        if self.area is not None:
            return float((self.area[1] - self.area[0]) * (self.area[3] - self.area[2]))
        return None if self.reach is None else pi * self.reach**2

    def limits(self) -> tuple[tuple[float, float, float, float], tuple[float, float, float]]:
        """The box and the circle (x, y, radius) outside of which it sees nothing; infinite where not declared."""
        box = tuple(float(v) for v in self.area) if self.area is not None else (-inf, inf, -inf, inf)
        circle = (float(self.site[0]), float(self.site[1]), inf if self.reach is None else float(self.reach))
        return box, circle  # pyright: ignore[reportReturnType]
