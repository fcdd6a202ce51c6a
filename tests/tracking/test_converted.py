"""A filter of positions on a radar's plots, and truth in a radar's file for a fit."""

import numpy as np
import polars as pl
import pytest

import jink
from jink.fit import fit
from jink.scenarios import by_name
from jink.scenarios.observation import Seeing
from jink.scenarios.table import simulation_table


@pytest.fixture(scope="module")
def radar():
    return simulation_table(Seeing(sensor="radar-4s").of(by_name("random-turns")).simulate(8, seed=1))


def _rms(tracks, table, late=30.0):
    tracks = tracks.filter(pl.col("time") > late)
    rows = table[tracks["row"].to_numpy()]
    return float(np.sqrt(((tracks["x"] - rows["true_x"]) ** 2 + (tracks["y"] - rows["true_y"]) ** 2).mean()))


def test_a_filter_of_positions_takes_a_radars_plots_with_their_covariances(radar):
    own = jink.track(radar)
    positions = jink.track(radar, filter=jink.default_filter("aircraft", jink.Position(sd=[50.0, 50.0, 10.0], axes=3)))
    assert positions.height == own.height
    # positions with covariances of the first order lose next to nothing at these ranges
    assert _rms(positions, radar) < 1.1 * _rms(own, radar)


def test_truth_in_a_radars_file_serves_a_fit(radar, tmp_path):
    radar.write_parquet(tmp_path / "radar.parquet")
    found = fit(str(tmp_path / "radar.parquet"), "kalman-cv", truth="true", starts=1, minutes=0.05)
    assert "position_rmse" in found.race.metrics
    shifted = radar.with_columns(pl.col("true_x") + 50_000.0)
    shifted.write_parquet(tmp_path / "shifted.parquet")
    with pytest.raises(ValueError, match="median distance of px from the measured position is 5"):
        fit(str(tmp_path / "shifted.parquet"), "kalman-cv", truth="true", starts=1, minutes=0.05)
