"""x and y beside range and azimuth have the noise of these: along the line of sight, and across it by the range."""

from __future__ import annotations

import numpy as np
import polars as pl
import pytest

import jink
from jink.io.geodesy import SiteFrame

RANGE_SD, AZIMUTH_SD = 30.0, 3e-3


def seen(seed: int = 0, count: int = 200) -> tuple[pl.DataFrame, np.ndarray]:
    """A flight past a radar at 100 km, which is rougher across the line of sight than along it; and the truth."""
    rng = np.random.default_rng(seed)
    time = 4.0 * np.arange(float(count))
    truth = np.column_stack([200.0 * time - 80e3, 80e3 + 3e3 * np.sin(time / 60.0)])
    reach = np.hypot(*truth.T) + rng.normal(0.0, RANGE_SD, count)
    azimuth = np.arctan2(*truth.T) + rng.normal(0.0, AZIMUTH_SD, count)
    columns = {"x": reach * np.sin(azimuth), "y": reach * np.cos(azimuth), "range": reach}
    table = pl.DataFrame({"target": "A", "time": time, **columns, "azimuth_deg": np.degrees(azimuth) % 360.0})
    return table, truth


def rms(tracks: pl.DataFrame, truth: np.ndarray) -> float:
    return float(np.sqrt((((tracks.select("x", "y").to_numpy() - truth)[10:]) ** 2).sum(axis=1).mean()))


def test_x_and_y_of_a_radar_have_the_noise_of_range_and_azimuth():
    errors = []
    for seed in range(4):
        table, truth = seen(seed)
        with_both = jink.track(table, details=True)
        line = with_both.summary["noise"][0]
        assert abs(line["range_sd"] / RANGE_SD - 1.0) < 0.3 and abs(line["azimuth_sd"] / AZIMUTH_SD - 1.0) < 0.3
        assert any("radar at the origin" in note for note in with_both.summary["notes"])
        plain = jink.track(table.drop("range", "azimuth_deg"))
        polar = jink.track(table.drop("x", "y"))
        errors.append([rms(each, truth) for each in (with_both.tracks, plain, polar)])
    both, plain, polar = np.sqrt(np.square(errors).mean(axis=0))
    assert both < 0.95 * plain and both < 1.03 * polar


@pytest.mark.parametrize("named", [False, True])
def test_a_plot_at_the_radar_itself_has_a_covariance(named):
    table, _ = seen()
    table[50, "x"] = table[50, "y"] = table[50, "range"] = 0.0
    if named:
        site = SiteFrame(48.0, 11.0, 0.0)
        latitude, longitude, *_ = site.to_geographic(table["x"].to_numpy(), table["y"].to_numpy(), None)
        places = {"latitude": latitude, "longitude": longitude}
        table = table.select("target", "time").with_columns(**{k: pl.Series(v) for k, v in places.items()})
    done = jink.track(table, details=True, **({"site": (48.0, 11.0, 0.0)} if named else {}))
    assert "range_sd" in done.summary["noise"][0] and done.tracks.height == table.height


def test_given_noises_are_taken():
    table, _ = seen()
    line = jink.track(table, sensor_sd={"range": 50.0, "azimuth": 2e-3}, details=True).summary["noise"][0]
    assert (line["range_sd"], line["azimuth_sd"]) == (50.0, 2e-3)
    assert "range_sd" not in jink.track(table, sensor_sd=100.0, details=True).summary["noise"][0]


def test_ranges_of_something_else_are_not_used():
    table, _ = seen()
    for other in (table.with_columns(pl.col("range") * 3.0), table.with_columns(pl.col("x") + 50e3)):
        done = jink.track(other, details=True)
        assert "range_sd" not in done.summary["noise"][0]
        assert {"range", "azimuth_deg"} <= set(done.summary["unused_columns"])


def on_the_map(table: pl.DataFrame) -> pl.DataFrame:
    """The positions as latitudes and longitudes around a site at 48 north, 9 east."""
    latitude, longitude, *_ = SiteFrame(48.0, 9.0).to_geographic(table["x"].to_numpy(), table["y"].to_numpy())
    return table.select("target", "time").with_columns(latitude=pl.Series(latitude), longitude=pl.Series(longitude))


@pytest.mark.parametrize("form", ["x and y", "places"])
def test_where_a_site_is_named_the_scatter_says_whether_it_is_a_radar_s(form):
    table, _ = seen(1, count=400)
    table = table.drop("range", "azimuth_deg")
    rng, even = np.random.default_rng(2), seen(1, count=400)[1]
    even = even + rng.normal(0, 100.0, even.shape)
    evenly = table.with_columns(x=pl.Series(even[:, 0]), y=pl.Series(even[:, 1]))
    if form == "places":
        table, evenly = on_the_map(table), on_the_map(evenly)
    line = jink.track(table, site=(48.0, 9.0), details=True).summary["noise"][0]
    assert abs(line["range_sd"] / RANGE_SD - 1.0) < 0.3 and abs(line["azimuth_sd"] / AZIMUTH_SD - 1.0) < 0.3
    assert "range_sd" not in jink.track(evenly, site=(48.0, 9.0), details=True).summary["noise"][0]
    assert "range_sd" not in jink.track(table, details=True).summary["noise"][0]


def test_aircraft_that_report_themselves_are_not_seen_by_a_radar():
    done = jink.track("examples/flights.parquet", site=(48.7, 2.4), details=True)
    assert all("range_sd" not in line for line in done.summary["noise"])
