"""Accuracies of velocities that a source states: ADS-B's NACv, and columns of accuracy."""

import numpy as np
import polars as pl
import pytest
from test_reported import _errors, _ships

import jink
from jink.io.loading import Reading, load_frame


def _mixed(seed=3):
    """Ships of which every second one has velocities twenty times as rough; the categories say so."""
    ships = _ships(seed, speed_sd=0.1, course_sd=0.014)
    rng = np.random.default_rng(seed + 1)
    vx = ships["true_vx"].to_numpy() + 0.1 * rng.normal(size=ships.height)
    vy = ships["true_vy"].to_numpy() + 0.1 * rng.normal(size=ships.height)
    rough = (ships["target"].str.tail(1).cast(pl.Int64) % 2 == 1).to_numpy()
    vx, vy = (v + np.where(rough, 2.0, 0.0) * rng.normal(size=ships.height) for v in (vx, vy))
    ships = ships.with_columns(vx=pl.Series(vx), vy=pl.Series(vy), nac_v=pl.Series(np.where(rough, 2, 4)))
    return ships.drop("sog", "cog")


def test_each_row_has_the_accuracy_that_its_category_says():
    rows = load_frame(_mixed().select("target", "time", "x", "y", "vx", "vy", "nac_v"), Reading()).measurements.rows
    # bounds of 3 and 0.3 m/s hold 95 % of the errors in the plane
    bound = np.sqrt(-2.0 * np.log(0.05))
    assert sorted(set(rows["velocity_sd"].round(9))) == pytest.approx([0.3 / bound, 3.0 / bound])


def test_rough_velocities_count_less_where_their_source_says_so():
    ships = _mixed()
    given = ships.select("target", "time", "x", "y", "vx", "vy", "nac_v")
    with_ = jink.track(given, kind="vessel", details=True)
    without = jink.track(given.drop("nac_v"), kind="vessel", details=True)
    assert with_.summary["columns"]["nacv"] == "nac_v"
    assert any("the reported velocity is used" in note for note in with_.summary["notes"])
    assert _errors(with_.tracks, ships)[0] < 0.97 * _errors(without.tracks, ships)[0]
    assert _errors(with_.tracks, ships)[1] < 0.8 * _errors(without.tracks, ships)[1]


@pytest.mark.parametrize(("name", "values"), [("speed_accuracy", 0.1), ("sAcc [cm/s]", 10.0), ("s_variance_m_s", 0.1)])
def test_columns_of_speed_accuracy(name, values):
    ships = _ships().with_columns(pl.lit(values).alias(name))
    given = ships.select("target", "time", "x", "y", "sog", "cog", name)
    rows = load_frame(given, Reading()).measurements.rows
    assert rows["velocity_sd"].to_numpy() == pytest.approx(0.1)


def test_categories_beside_no_velocity_mean_nothing():
    given = _mixed().select("target", "time", "x", "y", "nac_v")
    loaded = load_frame(given, Reading()).measurements
    assert "velocity_sd" not in loaded.rows.columns and "nacv" not in loaded.named


def test_live_rows_may_state_them():
    tracker = jink.LiveTracker("vessel")
    for k in range(6):
        row = tracker.update("A", float(10 * k), x=70.0 * k, y=0.0, vx=7.0, vy=0.0, nac_v=3)
    assert row is not None and row["velocity_x"] == pytest.approx(7.0, abs=1.0)
