"""What a named filter is made for, and what comes of it."""

from __future__ import annotations

from collections.abc import Callable
from math import ceil, log, sqrt
from typing import TYPE_CHECKING, Any

from ..checks import probability, whole
from ..frozen import frozen
from ..models.outliers import Outliers
from ..models.sensor import Position, Sensor
from ..models.switching import Sojourn
from .targets import KINDS

if TYPE_CHECKING:
    from ..filters.loading import AnyFilter


class Unfit(ValueError):
    """This filter cannot be made for this purpose; the message says why."""


@frozen(kw_only=True)
class Purpose:
    """What a filter is made for: the sensor, the kind of target and, where there are any, data to be fitted on.

    name of the scenario or file; sd (m) of a measured position and interval (s) between scans, the scale of a
    search; loss(filter) on data that are not scored, None where there are none; fitted, these data in words.
    per_axis: filters that can run along each axis by themselves. outliers as the filter should expect them.
    gap (s): tracks are cut at longer ones, so no filter has to give one up; recorded: real data. assumed (m/s²): the
    largest acceleration by the source of a scenario.
    """

    sensor: Sensor
    kind: str = "aircraft"
    name: str = ""
    sd: float = 1.0
    interval: float = 1.0
    loss: Callable[[AnyFilter], float] | None = None
    fitted: str = ""
    per_axis: bool = False
    outliers: Outliers | None = None
    gap: float | None = None
    recorded: bool = False
    assumed: float | None = None

    @property
    def axes(self) -> int:
        """Of the space the filter works in."""
        return int(self.sensor.axes or 2)

    @property
    def acceleration(self) -> float:
        """What this kind of target pulls when it manoeuvres, m/s²."""
        return KINDS[self.kind].acceleration

    @property
    def largest(self) -> float:
        """What the data's source assumes that targets pull at most, m/s²; else what this kind pulls."""
        return self.acceleration if self.assumed is None else self.assumed

    @property
    def scans_to_show(self) -> int:
        """Scans after which the kind's acceleration has moved a target by three sd of the sensor: a (n T)²/2 ≥ 3 sd."""
        return max(1, ceil(sqrt(6.0 * self.sd / self.acceleration) / self.interval))

    @property
    def position_sd(self) -> float:
        """Of a measured position along the first axis, m. Errors: Unfit where it is not the same everywhere."""
        if not self.sensor.cartesian:
            raise Unfit(
                f"it needs one noise in metres; that of a sensor of {self.sensor.components[0]} depends on the place"
            )
        return sqrt(self.sensor.noise[0, 0])

    def staying(self, stay: float, modes: int) -> Sojourn:
        """The chain of equally likely changes in which a mode outlasts one interval with probability ``stay``."""
        even = 1.0 - 1.0 / whole("modes", modes, 2, 512)
        if probability("stay", stay) <= 1.0 / modes:
            raise ValueError(f"stay: expected more than 1/{modes}, the share of each mode, got {stay:g}")
        rate = -even * log((stay - 1.0 / modes) / even) / self.interval
        return Sojourn(seconds=[1.0 / rate] * modes)

    @property
    def seen(self) -> Sensor:
        """The sensor a filter is built for: one axis of it where filters run along each axis."""
        sd = getattr(self.sensor, "sd", None)
        if self.per_axis and self.sensor.position_only and isinstance(sd, int | float):
            return Position(sd=sd, axes=1)
        return self.sensor


@frozen(kw_only=True)
class Named:
    """A filter by name, made for a purpose.

    words: what it is; fitted: on which data like those it is for, "" for none; note: what else a reader must know.
    """

    filter: Any
    words: str
    fitted: str = ""
    note: str = ""
