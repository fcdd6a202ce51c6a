"""A filter that was asked for and does not suit the targets is named in the summary."""

from pathlib import Path

import numpy as np
import polars as pl
import pytest

import jink
from jink.models.corrector import Corrector
from jink.models.network import Network
from jink.tracking.foretold import foretells_badly

FLIGHTS = Path(__file__).parents[2] / "examples" / "flights.parquet"


@pytest.fixture(scope="module")
def warned():
    def found(**options) -> dict[str, str]:
        summary = jink.track(FLIGHTS, details=True, **options).summary
        return {warning["code"]: warning["message"] for warning in summary["warnings"]}

    return found


def test_a_filter_of_other_targets_on_the_example_flights(warned):
    said = warned(filter="imm-cv-ct")["foretells_badly"]
    assert "by a straight line through the last two measurements" in said and "jink fit" in said


def test_one_that_suits_raises_nothing_nor_does_the_default(warned):
    assert "foretells_badly" not in warned(filter="imm")
    assert "foretells_badly" not in warned()


def test_errors_are_those_of_lines_that_go_on():
    # the measured line turns by a right angle at each row, the estimate stands still
    t = np.arange(203.0)
    zigzag = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])[np.arange(203) % 4]
    still = {"x": 0.5, "y": 0.5, "velocity_x": 0.0, "velocity_y": 0.0, "status": "updated", "part": 0, "target": "a"}
    table = pl.DataFrame({"time": t, "measured_x": zigzag[:, 0], "measured_y": zigzag[:, 1]}).with_columns(
        **{name: pl.lit(value) for name, value in still.items()}
    )
    assert foretells_badly(table) == []
    wrong = table.with_columns(velocity_x=pl.lit(30.0))
    (found,) = foretells_badly(wrong)
    # straight on from the square's side: √2 m beside the corner; the estimate about 30 m beside it
    assert "to 30 m, to 1.41 m by" in found.what and found.rows == 201


def circling(interval, sd):
    rng, time = np.random.default_rng(1), interval * np.arange(300.0)
    tables = []
    for k in range(4):
        rate = np.where(np.arange(300) % 40 > 25, np.radians(rng.uniform(1.0, 4.0)), 0.0)
        course = np.cumsum(rate * interval)
        way = 250.0 * interval * np.cumsum([np.cos(course), np.sin(course)], axis=1)
        x, y = way + rng.normal(0, sd, way.shape)
        tables.append(
            pl.DataFrame({"target": str(k), "time": time, "x": x, "y": y, "true_x": way[0], "true_y": way[1]})
        )
    return pl.concat(tables)


def misled(sd):
    """A filter whose aid adds ten sds to every position."""
    model = Network(weights=(np.zeros((2, 2)), np.zeros((1, 2))), biases=(np.zeros(2), np.ones(1)))
    same = {"low": (-1e5,) * 2, "high": (1e5,) * 2, "centre": (0.0,) * 2, "scale": (1.0,) * 2}
    aid = Corrector(model=model, inputs="titi-guney", **same, output_scale=(10 * sd,))
    motion = jink.ConstantVelocity(acceleration_psd=1000.0)
    return jink.Aided(jink.Kalman(motion, jink.Position(sd=sd)), aid)


@pytest.mark.parametrize(
    "filter, interval, sd, named",
    [
        ("nn-kf", 1.0, 50.0, False),
        # the prediction errs a hundred times more than the measurement, as in no training run
        ("nn-kf", 15.0, 5.0, False),
        ("anfis-kf", 15.0, 5.0, False),
        ("imm", 15.0, 5.0, False),
        (misled(5.0), 15.0, 5.0, True),
    ],
)
def test_estimates_far_from_the_plots_they_took_are_named(filter, interval, sd, named):
    data = circling(interval, sd)
    done = jink.track(data.drop("true_x", "true_y"), kind="fighter", filter=filter, sensor_sd=sd, details=True)
    codes = {warning["code"] for warning in done.summary["warnings"]}
    off = np.hypot(*(done.tracks[a].to_numpy() - data[f"true_{a}"].to_numpy() for a in "xy"))
    # the distance of a plot itself is √2 sd
    assert (np.sqrt(np.mean(off**2)) > 1.7 * sd) == named
    assert ("strays" in codes) == named


@pytest.mark.parametrize("heights", [True, False])
def test_a_filter_of_two_axes_is_why_heights_are_not_used(heights):
    rng, time = np.random.default_rng(2), np.arange(40.0)
    data = pl.DataFrame(
        {"target": "a", "time": time, "x": 200 * time + rng.normal(0, 5, 40), "y": rng.normal(0, 5, 40)}
    )
    if heights:
        data = data.with_columns(z=pl.Series(3000 + rng.normal(0, 5, 40)))
    plane = jink.Kalman(jink.ConstantVelocity(acceleration_psd=1.0), jink.Position(sd=5.0))
    note, _ = jink.track(data, filter=plane, details=True).summary["notes"]
    assert ("as the filter has two axes" in note) == heights and ("have no altitude" in note) != heights


@pytest.mark.parametrize("options, said", [({}, True), ({"sensor_sd": 5.0}, False)])
def test_a_filter_s_own_noise_is_said(options, said):
    rng, time = np.random.default_rng(2), np.arange(40.0)
    data = pl.DataFrame(
        {"target": "a", "time": time, "x": 200 * time + rng.normal(0, 5, 40), "y": rng.normal(0, 5, 40)}
    )
    own = jink.Kalman(jink.ConstantVelocity(acceleration_psd=1.0), jink.Position(sd=50.0))
    for filter, expected in ((own, said), ("kalman-cv", False), (None, False)):
        notes = jink.track(data, filter=filter, details=True, **options).summary["notes"]
        assert any("its sensor's own noise of 50 m" in note for note in notes) == expected
