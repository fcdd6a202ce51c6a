"""Two sources of which one clock is hours off: said where their paths tell, and nowhere else."""

from __future__ import annotations

import numpy as np
import polars as pl
import pytest

import jink
from jink.tracking.hours_apart import hours_apart

HOUR = 3600.0


def path(seed: int, count: int = 400, speed: float = 150.0) -> tuple[np.ndarray, np.ndarray]:
    """Places (m) every 5 s of a target that turns now and then, without noise."""
    rng = np.random.default_rng(seed)
    course = np.cumsum(np.repeat(rng.normal(0, 0.01, count // 40), 40))
    return np.cumsum(5 * speed * np.sin(course)) + 2e4 * seed, np.cumsum(5 * speed * np.cos(course))


def seen(apart: float, targets: int = 3, noise: float = 30.0, speed: float = 150.0) -> pl.DataFrame:
    """Two sources that take turns at random; the times of the second are `apart` seconds late."""
    rng, tables = np.random.default_rng(7), []
    for k in range(targets):
        x, y = path(k, speed=speed)
        second = rng.random(x.size) < 0.5
        table = {"target": f"T{k}", "time": 1.7e9 + 5.0 * np.arange(x.size) + np.where(second, apart, 0.0)}
        table |= {"x": x + rng.normal(0, noise, x.size), "y": y + rng.normal(0, noise, x.size)}
        tables.append(pl.DataFrame(table | {"source": np.where(second, "B", "A")}))
    return pl.concat(tables).sort("time")


def placed(table: pl.DataFrame, position: str) -> pl.DataFrame:
    if position == "geographic":
        lat = 50.0 + pl.col("y") / 111_195.0
        lon = 179.9 + pl.col("x") / (111_195.0 * lat.radians().cos())
        return table.with_columns(latitude=lat, longitude=(lon + 180.0) % 360.0 - 180.0)
    if position == "polar":
        return table.with_columns(range=(pl.col("x") ** 2 + pl.col("y") ** 2).sqrt(), azimuth=pl.arctan2("x", "y"))
    return table


@pytest.mark.parametrize("position", ["cartesian", "geographic", "polar"])
@pytest.mark.parametrize("hours", [1.0, -2.0, 5.5, 14.0])
def test_hours_between_two_sources_are_found(position, hours):
    (found,) = hours_apart(placed(seen(hours * HOUR), position), position)
    assert found.what == f"B has the same path as A, {abs(hours):g} h {'later' if hours > 0 else 'earlier'}"
    assert (found.count, found.rows) == (3, 1200)


@pytest.mark.parametrize("apart", [0.0, 4.0, 30.0, 600.0, 24 * HOUR, 1.25 * HOUR])
def test_other_clocks_are_not_said_to_be_hours_apart(apart):
    assert hours_apart(seen(apart), "cartesian") == []


def test_targets_at_rest_and_one_source_tell_nothing():
    assert hours_apart(seen(HOUR, speed=0.0), "cartesian") == []
    assert hours_apart(seen(HOUR).with_columns(source=pl.lit("A")), "cartesian") == []
    assert hours_apart(seen(HOUR).with_columns(source="target"), "cartesian") == []


@pytest.mark.parametrize("late", [3.0, 10.0, 30.0])
@pytest.mark.parametrize("hours", [1, 2, 6])
def test_a_ferry_on_its_timetable_is_in_the_same_place_each_hour(late, hours):
    """One target, in files of so many hours; each trip leaves late by so many seconds (one sd)."""
    rng, time = np.random.default_rng(1), np.arange(0.0, 24 * HOUR, 10.0)
    trip = (time // HOUR).astype(int)
    done = (time - trip * HOUR - rng.normal(0, late, 24)[trip]) / HOUR
    way = 12_000.0 * np.interp(done, [0.0, 0.05, 0.45, 0.55, 0.95, 1.0], [0, 0, 1, 1, 0, 0])
    x, y = way + rng.normal(0, 5, time.size), 0.2 * way + rng.normal(0, 5, time.size)
    rows = pl.DataFrame({"target": "ferry", "time": 1.7e9 + time, "x": x, "y": y})
    rows = rows.with_columns(source=pl.Series((time // (hours * HOUR)).astype(int)).cast(pl.String))
    assert hours_apart(rows, "cartesian") == []


def test_files_of_two_zones_are_warned_of(tmp_path):
    table = placed(seen(2 * HOUR, noise=10.0), "geographic").drop("x", "y")
    for (name,), rows in table.group_by(["source"]):
        rows.drop("source").write_csv(tmp_path / f"{name}.csv")
    files = [tmp_path / "A.csv", tmp_path / "B.csv"]
    (warning,) = jink.track(files, details=True).summary["warnings"][:1]
    assert warning["code"] == "hours_apart" and "B.csv has the same path as" in warning["message"]
    right = table.filter(pl.col("source") == "B").with_columns(pl.col("time") - 2 * HOUR)
    right.drop("source").write_csv(tmp_path / "B.csv")
    assert jink.track(files, details=True).summary["warnings"] == []
