"""A filter that was asked for and does not suit the targets is named in the summary."""

from pathlib import Path

import numpy as np
import polars as pl
import pytest

import jink
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
