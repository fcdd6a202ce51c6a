"""Many targets of a few rows each tell the noise of their source together."""

from __future__ import annotations

import numpy as np
import polars as pl
import pytest

import jink
from jink.tracking.scatter import LEAST

SD = {"position": 20.0, "altitude": 8.0}


def sky(targets: int, rows: int) -> pl.DataFrame:
    """Straight and level flights at 200 m/s on the map, a row every 4 s."""
    rng = np.random.default_rng(3)
    course, k = np.repeat(rng.uniform(0.0, 2.0 * np.pi, targets), rows), np.tile(np.arange(rows), targets)
    east, north = (800.0 * k * f(course) + rng.normal(0.0, SD["position"], k.size) for f in (np.sin, np.cos))
    return pl.DataFrame(
        {
            "target": [f"t{i:03d}" for i in np.repeat(np.arange(targets), rows)],
            "time": 4.0 * k,
            "latitude": north / 110_574.0,
            "longitude": east / 111_320.0,
            "altitude": np.repeat(rng.uniform(3e3, 1e4, targets), rows) + rng.normal(0.0, SD["altitude"], k.size),
        }
    )


def noise(data: pl.DataFrame) -> dict:
    (line,) = jink.track(data, details=True).summary["noise"]
    return line


def test_they_tell_it_together() -> None:
    rows = LEAST // 2
    line = noise(sky(200, rows))
    # 200 targets of seven differences each: the error of the median is about 4 %, so 12 % are three of them
    for name, sd in SD.items():
        assert line[f"{name}_sd"] == pytest.approx(sd, rel=0.12)
        assert line[f"{name}_sd_from"] == "estimated"


def test_too_few_rows_in_all_tell_nothing() -> None:
    line = noise(sky(2, 5))
    assert line["position_sd_from"] == line["altitude_sd_from"] == "assumed"


def test_a_long_target_tells_it_for_the_short_ones() -> None:
    long = sky(1, 400).with_columns(target=pl.lit("long"))
    alone, both = noise(long), noise(pl.concat([long, sky(20, 8)]))
    for name in SD:
        assert both[f"{name}_sd"] == pytest.approx(alone[f"{name}_sd"], rel=1e-6)
