"""Errors that last, and slant ranges without heights, are said with what mends them."""

from __future__ import annotations

import numpy as np
import polars as pl
import pytest

import jink
from jink.io.errors import InputError

DURATION = 1200
DEGREE = np.array([111_319.49, 110_574.28])  # m, of longitude and latitude on the equator


def walk(seconds: float, seed: int = 0, sd: float = 3.0) -> tuple[pl.DataFrame, np.ndarray]:
    """A walker with errors of sd 3 m that last for `seconds`, and 0.3 m of white noise; and the truth."""
    rng = np.random.default_rng(seed)
    time = np.arange(float(DURATION))
    kept = np.exp(-1.0 / seconds) if seconds else 0.0
    error = np.zeros((DURATION, 2))
    error[0] = rng.normal(0, sd, 2)
    for k in range(1, DURATION):
        error[k] = kept * error[k - 1] + rng.normal(0, sd * np.sqrt(1 - kept**2), 2)
    truth = np.column_stack([1.4 * time, 0.3 * time])
    seen = truth + error + rng.normal(0, 0.3, (DURATION, 2))
    return pl.DataFrame({"target": "A", "time": time, "x": seen[:, 0], "y": seen[:, 1]}), truth


def codes(data: pl.DataFrame, **more) -> dict:
    found = jink.track(data, details=True, **more).summary["warnings"]
    return {warning["code"]: warning for warning in found}


def inside(data: pl.DataFrame, truth: np.ndarray, **more) -> float:
    """Share of errors inside two sds."""
    tracks = jink.track(data, kind="person", **more)
    error = np.abs(tracks.select("x", "y").to_numpy() - truth)[60:]
    return float((error <= 2.0 * tracks.select("x_sd", "y_sd").to_numpy()[60:]).mean())


@pytest.mark.parametrize("seed", range(3))
def test_errors_that_last_are_said(seed):
    data, truth = walk(8.0, seed)
    found = codes(data, kind="person")["correlated"]
    given = float(found["mend"].split()[1])
    assert 1.8 < given < 4.5
    assert not codes(data, kind="person", sensor_sd=given).keys() & {"correlated", "noise_given"}
    # taken for independent errors they are not all there is
    assert inside(data, truth) > inside(data, truth, sensor_sd=given) + 0.05


@pytest.mark.parametrize("how", [{}, {"smooth": True}])
def test_errors_that_last_are_carried(how):
    """On the mean over walks; before they were, a third to a half of the errors were inside two sds."""
    shares = [inside(*walk(8.0, seed), **how) for seed in range(6)]
    assert np.mean(shares) >= 0.93 and min(shares) > 0.8
    white = [inside(*walk(0.0, seed), **how) for seed in range(6)]
    assert np.mean(white) < 0.995


def winding(seed: int) -> tuple[pl.DataFrame, np.ndarray]:
    """Five minutes of a walker who turns every 20 s, with such errors of 3 m and 8 s; and the truth."""
    straight, truth = walk(8.0, seed)
    error = (straight.select("x", "y").to_numpy() - truth)[:300]
    rate = np.where(np.arange(300) // 20 % 2 == 1, 0.08, 0.0) * np.where(np.arange(300) // 40 % 2 == 1, 1.0, -1.0)
    course = np.cumsum(rate)
    way = 500.0 + np.cumsum(1.4 * np.column_stack([np.cos(course), np.sin(course)]), axis=0)
    seen = way + error
    return pl.DataFrame({"target": "T", "time": np.arange(300.0), "x": seen[:, 0], "y": seen[:, 1]}), way


def on_the_map(data: pl.DataFrame) -> pl.DataFrame:
    """Near 0 N 0 E, where each target has a noise of its own."""
    return data.select("target", "time", longitude=pl.col("x") / DEGREE[0], latitude=pl.col("y") / DEGREE[1])


def test_who_turns_has_the_errors_of_those_who_go_straight():
    """Alone, five minutes of turns cannot tell that errors last."""
    alone, beside = [], []
    for seed in range(6):
        turning, truth = winding(seed)
        both = pl.concat([turning, walk(8.0, seed + 10)[0]])
        for shares, data in ((alone, turning), (beside, both)):
            tracks = jink.track(on_the_map(data), kind="person").filter(pl.col("target") == "T")
            error = np.abs(tracks.select("longitude", "latitude").to_numpy() * DEGREE - truth)[60:]
            shares.append(float((error <= 2.0 * tracks.select("x_sd", "y_sd").to_numpy()[60:]).mean()))
    assert np.mean(alone) < 0.6 and np.mean(beside) >= 0.9


def test_who_clearly_has_no_such_errors_keeps_its_own():
    """Two walkers have errors that last; the third one's are white, and a tenth as large."""
    rough = [walk(8.0, seed)[0].with_columns(target=pl.lit(f"rough {seed}")) for seed in range(2)]
    data = pl.concat([*rough, walk(0.0, 5, sd=0.2)[0]])
    tracks = jink.track(on_the_map(data), kind="person")
    sd = {name[0]: rows["x_sd"].median() for name, rows in tracks.group_by("target")}
    assert sd["A"] < 0.4 and min(sd["rough 0"], sd["rough 1"]) > 1.5


@pytest.mark.parametrize("seed", range(3))
def test_white_errors_are_not_suspected(seed):
    assert codes(walk(0.0, seed)[0], kind="person") == {}


@pytest.mark.parametrize("seed", range(3))
def test_circles_are_motion(seed):
    time = 0.5 * np.arange(1200)
    circle = 20.0 * np.stack([np.cos(0.5 * time), np.sin(0.5 * time)]) + np.random.default_rng(seed).normal(
        0, 1.0, (2, 1200)
    )
    data = pl.DataFrame({"target": "A", "time": time, "x": circle[0], "y": circle[1]})
    assert codes(data, kind="drone") == {}


def flight(height: float, seed: int = 0) -> pl.DataFrame:
    """A flight past a radar at 3 km, by its range and azimuth."""
    rng = np.random.default_rng(seed)
    time = 4.0 * np.arange(150)
    x, y = 200.0 * time - 60e3, np.full(time.size, 3e3)
    distance = np.sqrt(x**2 + y**2 + height**2) + rng.normal(0, 30.0, time.size)
    azimuth = np.degrees(np.arctan2(x, y) + rng.normal(0, 1e-3, time.size)) % 360.0
    return pl.DataFrame({"target": "A", "time": time, "range": distance, "azimuth_deg": azimuth})


@pytest.mark.parametrize("height", [3000.0, 9000.0])
def test_slant_ranges_are_said(height):
    found = codes(flight(height))["slant_range"]
    assert f"{height:.0f}" in found["what"] and "altitude=NAME" in found["mend"]


def test_ranges_along_the_ground_are_not_suspected():
    assert "slant_range" not in codes(flight(0.0))
    assert "slant_range" not in codes(flight(9000.0).with_columns(altitude=pl.lit(9000.0)))


def apart() -> pl.DataFrame:
    """A target whose ranges and azimuths never stand in one row."""
    ranges, azimuths = [2e4, 2.01e4] + [None] * 10, [None] * 10 + [30.0, 31.0]
    return pl.DataFrame({"target": ["a"] * 12, "time": np.arange(12) * 4.0, "range": ranges, "azimuth_deg": azimuths})


APART = {"range": 20.0, "azimuth_deg": 0.1}


def test_ranges_and_azimuths_that_never_stand_in_one_row() -> None:
    with pytest.raises(InputError, match="target a: no row has an estimate"):
        jink.track(apart(), sensor_sd=APART)
    tracks = jink.track(apart(), sensor_sd=APART, check_coordinates=False)
    assert tracks.height == 12 and (tracks["status"] == "none").all() and tracks["x"].is_null().all()


def test_a_target_without_an_estimate_is_named_beside_others() -> None:
    time = np.arange(30) * 4.0
    good = pl.DataFrame({"target": "b", "time": time, "range": 2e4 + 50.0 * time, "azimuth_deg": 30.0 + 0.01 * time})
    found = codes(pl.concat([apart(), good]), sensor_sd=APART)["no_estimate"]
    assert (found["targets"], found["count"], found["rows"]) == (["a"], 1, 12)
    assert "no_estimate" not in codes(good, sensor_sd=APART)
