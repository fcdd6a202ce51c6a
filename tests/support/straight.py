"""A target on a straight line, and whether a track agrees with it: the same journey in every file that people have."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

import numpy as np
import polars as pl
from pyproj import Geod

GEOD = Geod(ellps="WGS84")
START = datetime(2024, 1, 15, 14, 30, tzinfo=UTC)


@dataclass(frozen=True)
class Journey:
    """`count` positions, one every `step` seconds, at `speed` m/s on a course in degrees."""

    count: int = 40
    step: float = 5.0
    speed: float = 20.0
    course: float = 60.0
    latitude: float = 51.0
    longitude: float = 7.0
    start: datetime = START

    @property
    def seconds(self) -> np.ndarray:
        """Since the start."""
        return self.step * np.arange(self.count)

    @property
    def places(self) -> list[tuple[float, float]]:
        """Latitude and longitude in degrees."""
        way = self.seconds * self.speed
        n = self.count
        east, north, _ = GEOD.fwd([self.longitude] * n, [self.latitude] * n, [self.course] * n, way)
        return list(zip(np.asarray(north).tolist(), np.asarray(east).tolist(), strict=True))

    @property
    def times(self) -> list[datetime]:
        """Date-times in UTC."""
        return [self.start + timedelta(seconds=float(second)) for second in self.seconds]

    def lines(self, text: str, form: str = "%Y-%m-%dT%H:%M:%SZ") -> list[str]:
        """One line per position; `text` may use {i}, {t} (time by `form`), {s} (seconds), {e} (epoch), {lat}, {lon}."""
        return [
            text.format(
                i=i, t=time.strftime(form), s=second, e=time.timestamp(), lat=place[0], lon=place[1], date=time, n=i + 1
            )
            for i, (time, second, place) in enumerate(zip(self.times, self.seconds.tolist(), self.places, strict=True))
        ]

    def agrees(self, tracks: pl.DataFrame, rows: int | None = None, start: bool = True) -> None:
        """Whether speed, course and start are right; rounding in the files is up to 1e-6 degrees, .1 m in 100 m."""
        assert tracks.height == (self.count if rows is None else rows)
        assert tracks["speed"].median() == np.clip(tracks["speed"].median(), 0.99 * self.speed, 1.01 * self.speed)
        course = np.degrees(np.angle(np.mean(np.exp(1j * tracks["course"].drop_nulls().to_numpy()))))
        assert abs((course - self.course + 180.0) % 360.0 - 180.0) < 1.0
        if start:
            first = tracks["time"].min()
            assert isinstance(first, datetime)
            assert abs((first - self.start).total_seconds()) < 1e-3
