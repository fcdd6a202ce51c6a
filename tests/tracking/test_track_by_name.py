"""`jink track --filter NAME` for every registered name, on a real flight."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import polars as pl
import pytest
from subjects import NOT_SMOOTHED
from typer.testing import CliRunner

import jink
from jink.catalogue.choose import choose_filter
from jink.catalogue.registry import FILTERS
from jink.cli.main import app

FLIGHTS = Path(__file__).parents[2] / "examples" / "flights.parquet"
SURE = dict.fromkeys(
    ["imm-cv-ct", "variable-dimension"], 0.15
)  # its straight mode takes some onsets for outliers: up to this share
UNFIT = {
    "nnvsmm": "its network was trained on two axes; the sensor has 3",
}


@pytest.fixture(scope="module")
def flight() -> pl.DataFrame:
    """700 s of a real flight, turns and a climb among them."""
    return pl.read_parquet(FLIGHTS).filter(pl.col("icao24") == "4d02c1").drop("callsign").head(700)


@pytest.fixture(scope="module")
def straight(flight) -> pl.DataFrame:
    """What the plainest filter makes of it."""
    return jink.track(flight, filter="kalman-cv", details=True).tracks


def smooths(name: str) -> list[bool]:
    return [False] if f"{name} (registered)" in NOT_SMOOTHED else [False, True]


@pytest.mark.parametrize("name", [n for n in FILTERS if n not in UNFIT])
def test_every_name_tracks_a_real_flight(name, flight, straight):
    """Finite throughout, hardly a position rejected, and nowhere far from what constant velocity says."""
    for smooth in smooths(name):
        tracks = jink.track(flight, filter=name, smooth=smooth, details=True).tracks
        assert tracks.height == straight.height > 600
        numbers = tracks.select("latitude", "longitude", "altitude", "x", "y", "z", "x_sd", "y_sd")
        assert np.isfinite(numbers.to_numpy()).all()
        # the velocity is unknown where a track begins
        moving = tracks.slice(5).filter(pl.col("status") != "restarted")
        assert np.isfinite(moving.select("speed", "velocity_x_sd").to_numpy()).all()
        assert (tracks["x_sd"] > 0).all()
        assert (tracks["status"] == "gated").mean() < SURE.get(name, 0.05)
        apart = np.hypot(*((tracks[c] - straight[c]).to_numpy() for c in ("x", "y")))
        assert np.median(apart) < 40.0 and np.sqrt(np.mean(apart**2)) < 150.0


@pytest.mark.parametrize("name", UNFIT)
def test_a_filter_that_cannot_track_this_says_why(name, flight):
    with pytest.raises(ValueError, match=f"filter {name} cannot track these data: {UNFIT[name]}"):
        jink.track(flight, filter=name)


@pytest.mark.parametrize("name", ["facs", "aimm3", "vsmm-ag", "fuzzy-imm", "anfis-kf"])
@pytest.mark.parametrize("smooth", [False, True], ids=["filter", "smooth"])
def test_the_command(name, smooth, flight, tmp_path):
    """Tracks and a summary; or, where a filter cannot be smoothed, one line that says what to do, and no output."""
    flight.write_parquet(tmp_path / "flight.parquet")
    arguments = ["track", str(tmp_path / "flight.parquet"), "--filter", name, "-o", str(tmp_path / "out.csv")]
    result = CliRunner(env={"COLUMNS": "400"}).invoke(app, arguments + ["--smooth"] * smooth)
    if smooth not in smooths(name):
        assert result.exit_code == 2, result.stderr
        assert "cannot be smoothed: " in result.stderr and "; smooth " in result.stderr
        assert not (tmp_path / "out.csv").exists()
        return
    assert result.exit_code == 0, result.stderr
    assert pl.read_csv(tmp_path / "out.csv").height > 600


@pytest.mark.parametrize("step", [1.0, 5.0])
def test_filters_are_told_the_usual_time_between_positions(step, monkeypatch):
    """Probabilities that the papers give per scan hold for the data's own scans."""
    asked = []
    aimm3 = FILTERS["aimm3"]
    monkeypatch.setitem(FILTERS, "aimm3", lambda purpose: asked.append(purpose) or aimm3(purpose))
    t = np.arange(60.0) * step
    frame = pl.DataFrame({"time": t, "x": 100.0 * t, "y": np.sin(t)})
    jink.track(frame, filter="aimm3", sensor_sd=10.0)
    (purpose,) = asked
    assert purpose.interval == step
    stays = [
        choose_filter(("x", "y"), {"position": 10.0}, "aircraft", "aimm3", interval=i).transition for i in (1.0, step)
    ]
    np.testing.assert_allclose(stays[1].seconds, np.multiply(stays[0].seconds, step))
