"""How a scenario is seen, as the command line says it: one sensor's options for `jink simulate` and `jink compare`."""

from __future__ import annotations

from dataclasses import astuple, replace
from math import isfinite
from typing import Any

from ..checks import unknown
from ..frozen import frozen
from ..io.errors import InputError


@frozen
class Seeing:
    """What was asked, None where the scenario's own stays.

    sensor a radar's name or a position noise (m); interval and jitter (s); detection a probability; outliers a
    share of scans; bias numbers with commas, one per measured component (m, rad, m/s).
    """

    sensor: str | None = None
    interval: float | None = None
    jitter: float | None = None
    detection: float | None = None
    outliers: float | None = None
    bias: str | None = None

    @property
    def asked(self) -> bool:
        """Is there anything to change?"""
        return any(each is not None for each in astuple(self))

    def of(self, scenario: Any) -> Any:
        """The scenario, seen so. Errors: ValueError."""
        if self.sensor is not None or self.interval is not None or self.jitter is not None:
            seen = scenario.observation if self.sensor is None else _sensor(self.sensor)
            scenario = scenario.seen_by(seen, interval=self.interval, jitter=self.jitter)
        given = {"detection": self.detection, "outlier_share": self.outliers}
        changes: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
        if self.bias is not None:
            changes["bias"] = _bias(self.bias)
        return replace(scenario, observation=replace(scenario.observation, **changes))


def _sensor(given: str) -> str | float:
    from . import RADARS

    if given in RADARS:
        return given
    try:
        sd = float(given)
    except ValueError:
        raise InputError(unknown("sensor", given, RADARS) + ", or a position noise in metres") from None
    if not 0 < sd < float("inf"):
        raise InputError(f"--sensor is {given}; expected a position noise above 0 m, or a radar's name")
    return sd


def _bias(given: str) -> tuple[float, ...]:
    try:
        numbers = tuple(float(item) for item in given.split(","))
        if all(map(isfinite, numbers)):
            return numbers
        raise ValueError
    except ValueError:
        raise InputError(
            f"--bias is {given!r}; expected numbers with commas, one per component (m, rad, m/s)"
        ) from None


def sensor_in_words(sensor: Any) -> str:
    """A sensor and its noise, in SI units."""
    noise = {n: v for n, v in vars(sensor).items() if n.endswith("sd") and v is not None}
    parts = [f"{name.removesuffix('_sd')} {_numbers(value)}" for name, value in noise.items()]
    return f"{type(sensor).__name__.lower()}, sd " + ", ".join(parts).removeprefix("sd ")


def _numbers(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, int | float) else "/".join(f"{each:.4g}" for each in value)


def in_words(scenario: Any) -> str:
    """How a scenario is seen: the sensor and its noise in SI units, what makes it worse, how often and how long."""
    seen, schedule = scenario.observation, scenario.schedule
    words = sensor_in_words(seen.sensor)
    if seen.detection < 1:
        words += f", detection {seen.detection:g}"
    if seen.outlier_share:
        words += f", {seen.outlier_share:.1%} outliers of {seen.outlier_scale:g} times the noise"
    words += f", bias {tuple(seen.bias)}" if seen.bias else ""
    jitter = f" ± {schedule.jitter:g}" if schedule.jitter else ""
    return f"{words}; {schedule.count} scans, one every {schedule.interval:.4g}{jitter} s"
