"""Files, streams and recorded races are prepared in one place: the same parts, noise and filter for the same rows."""

from __future__ import annotations

import json

import numpy as np
import polars as pl
import pytest

import jink
from jink.catalogue.registry import FILTERS
from jink.compare.recorded import read
from jink.io.loading import Reading, load_files
from jink.tracking.live import LiveTracks
from jink.tracking.prepare import Settings, prepare


def rare(step: float, count: int = 24) -> pl.DataFrame:
    """Two targets, each seen every so many seconds, in the order of time."""
    time = step * np.arange(count)
    each = [
        pl.DataFrame({"target": name, "time": time + late, "x": 3.0 * time, "y": 40.0 * np.sin(time / 200)})
        for name, late in (("a", 0.0), ("b", 0.3))
    ]
    return pl.concat(each).sort("time")


def streamed(table: pl.DataFrame, settings: Settings) -> pl.DataFrame:
    """One line at a time."""
    live = LiveTracks(Reading(), settings)
    said = [live.take([json.dumps(row).encode()])[0] for row in table.iter_rows(named=True)]
    return pl.DataFrame([json.loads(line) for line in said]).sort("target", "time")


@pytest.mark.parametrize("name", ["imm", "aimm3", "vsmm-ds"])
def test_a_stream_of_rare_positions_agrees_with_the_file(name, monkeypatch):
    """Steps of 100 s are no gaps, though a drone's tracks end after 60 s, and filters are told of them."""
    asked, make = [], FILTERS[name]
    monkeypatch.setitem(FILTERS, name, lambda purpose: asked.append(purpose) or make(purpose))
    table, given = rare(100.0), {"position": 20.0}
    live = streamed(table, Settings(filter=name, kind="drone", sensor_sd=given))
    whole = jink.track(table, filter=name, kind="drone", sensor_sd=given, drop_stale=False)
    assert live["part"].n_unique() == whole["part"].n_unique() == 1
    assert (asked[-2].interval, asked[-2].gap) == (asked[-1].interval, asked[-1].gap) == (100.0, 1000.0)
    whole = whole.sort("target", "time")
    for column in ("x", "y", "speed", "x_sd"):
        found, wanted = live[column].to_numpy().astype(float), whole[column].to_numpy().astype(float)
        np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9, err_msg=column)


def test_a_long_gap_begins_a_part_in_a_stream_as_in_a_file():
    table = rare(2.0)
    table = pl.concat([table, table.with_columns(pl.col("time") + 400.0)])
    live = streamed(table, Settings(sensor_sd={"position": 20.0}))
    assert live.group_by("target").agg(pl.col("part").unique().sort())["part"].to_list() == [[0, 1]] * 2


def test_a_race_on_a_file_has_the_parts_noise_and_filter_of_its_tracks(tmp_path):
    """Also where a column says which sensor measured: its noise is one for all targets then."""
    rng, frames = np.random.default_rng(4), []
    for k in range(10):
        time = 4.0 * np.arange(60)
        north, east = rng.normal(scale=30.0, size=(2, 60)) / 111_000
        place = {"latitude": 48.0 + 0.1 * k + 0.002 * np.arange(60) + north, "longitude": 11.0 + east}
        frames.append(pl.DataFrame({"target": f"t{k}", "time": time, **place, "sensor": "north"}))
    path = tmp_path / "radar.csv"
    pl.concat(frames).write_csv(path)
    prepared = prepare(load_files([path], Reading()).measurements, Settings())
    (group,) = prepared.groups
    recording = read(str(path), "aircraft", 0)
    assert group.placed.sensors_named
    np.testing.assert_array_equal(recording.tracks.offsets, group.placed.offsets)
    np.testing.assert_array_equal(recording.tracks.z, group.placed.z)
    assert recording.sensor == group.purpose.sensor
    assert recording.purpose.gap == prepared.pace.wait and recording.purpose.interval == 4.0
    assert FILTERS["imm-corrected"](recording.purpose).filter.described() == group.filter.described()
