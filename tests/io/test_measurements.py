"""Columns to SI units: what is assumed is said, what cannot be read is set aside with its value."""

import math

import numpy as np
import polars as pl
import pytest

from jink.io.columns import recognise
from jink.io.errors import InputError
from jink.io.measurements import Measurements, measure
from jink.io.rejected import together


def _measure(columns: dict[str, list], **options) -> Measurements:
    frame = pl.DataFrame(columns, strict=False)
    return measure("f.csv", frame.with_row_index("row"), recognise("f.csv", frame.columns), **options)


PLACES = {"id": ["a", "a", "a"], "t": [0, 1, 2], "lat": [45.0, 45.1, 45.2], "lon": [5.0, 5.1, 5.2]}


@pytest.mark.parametrize(
    ("extra", "options", "metres", "said"),
    [
        ({"altitude": [1000, 1000, 1000]}, {}, 1000.0, "metres"),
        (
            {"altitude": [1000] * 3, "groundspeed": [1, 1, 1], "vertical_rate": [0] * 3},
            {},
            304.8,
            "taken as feet",
        ),
        (
            {"altitude": [1000] * 3, "groundspeed": [1, 1, 1], "vertical_rate": [0] * 3},
            {"altitude_unit": "m"},
            1000.0,
            None,
        ),
        ({"altitude": [1000, 1000, 1000]}, {"altitude_unit": "ft"}, 304.8, None),
        (
            {"geoaltitude": [1000, 1000, 1000], "groundspeed": [1] * 3, "vertical_rate": [0] * 3},
            {},
            1000.0,
            None,
        ),
        ({"alt_baro": [1000, "ground", 1000]}, {}, 304.8, None),
        ({"flight_level": [10, 10, 10]}, {}, 304.8, None),
    ],
)
def test_the_unit_of_altitude_follows_a_stated_rule(extra, options, metres, said):
    found = _measure(PLACES | extra, **options)
    assert found.rows["altitude"][0] == pytest.approx(metres)
    # the height of rows on the ground is a note of its own: nothing was assumed of the unit
    units = [note for note in found.notes if "on the ground" not in note]
    assert any(said in note for note in units) if said else not units


FLAT = {"id": ["a", "a", "a"], "t": [0, 1, 2], "x": [0.0, 100.0, 200.0], "y": [0.0, 50.0, 100.0]}
NORTH = {"id": ["a", "a", "a"], "t": [0, 1, 2], "north": [0.0, 100.0, 200.0], "east": [0.0, 50.0, 100.0]}


@pytest.mark.parametrize(
    ("columns", "options", "metres"),
    [
        (FLAT | {"altitude": [1000] * 3}, {}, 1000.0),
        (FLAT | {"altitude": [1000] * 3}, {"altitude_unit": "ft"}, 304.8),
        (FLAT | {"flight_level": [10] * 3}, {}, 304.8),
        (FLAT | {"z": [1000] * 3}, {"altitude_unit": "ft"}, 304.8),
        # axes are north, east, down, but a height points up
        (NORTH | {"alt": [1000] * 3}, {}, 1000.0),
        (NORTH | {"down": [-1000] * 3}, {}, 1000.0),
        (NORTH | {"down": [-1000] * 3}, {"altitude_unit": "ft"}, 304.8),
    ],
)
def test_a_height_beside_x_and_y_points_up_in_its_unit(columns, options, metres):
    assert _measure(columns, **options).rows["z"][0] == pytest.approx(metres)


def test_a_height_that_the_user_names_goes_with_any_position():
    frame = pl.DataFrame(FLAT | {"hoehe": [7.0] * 3}).with_row_index("row")
    found = measure("f.csv", frame, recognise("f.csv", frame.columns, {"altitude": "hoehe"}))
    assert found.rows["z"].to_list() == [7.0] * 3


def test_a_column_that_the_user_names_in_vain_is_said():
    frame = pl.DataFrame(FLAT | {"b": [0.1] * 3}).with_row_index("row")
    found = measure("f.csv", frame, recognise("f.csv", frame.columns, {"elevation": "b"}))
    assert any("column 'b' is not used: --columns names it elevation" in note for note in found.notes)


def test_angles_without_a_unit_are_radians_until_one_value_is_too_large():
    small = _measure({"id": ["a", "a"], "t": [0, 1], "range": [1000, 1100], "azimuth": [0.1, 6.2]})
    large = _measure({"id": ["a", "a"], "t": [0, 1], "range_km": [1, 1.1], "azimuth": [0.1, 7.0]})
    assert small.rows["azimuth"][1] == 6.2 and "radians" in small.notes[0]
    assert large.rows["azimuth"][1] == pytest.approx(math.radians(7.0)) and "degrees" in large.notes[0]
    assert large.rows["range"].to_list() == [1000.0, 1100.0]


def test_every_rejected_row_names_its_reason_and_its_value():
    found = _measure(
        {
            "icao24": ["a", None, "c", "d", "e", "f", "g", "h", " "],
            "time": ["2024-01-01T00:00:00Z", "2024-01-01T00:00:00Z", "now", *["2024-01-01T00:00:00Z"] * 6],
            "latitude": ["45", "45", "45", "forty", "95", "0", "45", "45", "45"],
            "longitude": ["5", "5", "5", "5", "5", "0", None, "1e999", "5"],
        }
    )
    rejected = together(found.rejected)
    assert found.rows["row"].to_list() == [0]
    assert dict(zip(rejected["row"], rejected["reason"], strict=True)) == {
        1: "no identifier",
        2: "time is missing or unreadable",
        3: "latitude is not a number",
        4: "latitude beyond ±90°",
        5: "latitude and longitude exactly 0",
        6: "only one of latitude and longitude is given",
        7: "longitude beyond ±360°",
        8: "no identifier",
    }
    assert rejected.filter(pl.col("row") == 3)["value"].item() == "forty"
    assert rejected["file"].unique().to_list() == ["f.csv"]


def test_coordinates_are_believed_when_told_so():
    found = _measure({"t": [0], "lat": [0.0], "lon": [0.0]}, check_coordinates=False)
    assert found.rows.height == 1 and not found.rejected


def test_longitudes_to_360_degrees_are_wrapped():
    assert _measure({"t": [0], "lat": [10.0], "lon": [190.0]}).rows["longitude"].item() == pytest.approx(-170.0)


def test_an_unreadable_altitude_leaves_the_position():
    found = _measure(PLACES | {"altitude_m": ["100", "high", None]})
    np.testing.assert_array_equal(found.rows["altitude"].to_numpy(), [100.0, np.nan, np.nan])
    assert "1 unreadable altitudes" in found.notes[0] and not found.rejected


@pytest.mark.parametrize("values", [[235_000_001, 2, 3], [235_000_001.0, 2.0, 3.0], ["235000001", "2", "3"]])
def test_identifiers_are_text_without_a_decimal_point(values):
    assert _measure(PLACES | {"id": values}).rows["target"].to_list() == ["235000001", "2", "3"]


def test_without_identifier_all_rows_are_one_target_and_that_is_said():
    found = _measure({name: PLACES[name] for name in ("t", "lat", "lon")}, default_target="log")
    assert found.rows["target"].to_list() == ["log"] * 3 and "no identifier column" in found.notes[0]


def test_accuracy_categories_become_standard_deviations():
    found = _measure(PLACES | {"NACp": [8, 0, None], "nic": [8, 7, 15], "gva": [2, 1, 0]})
    sd = found.rows["position_sd"].to_numpy()
    assert sd[0] == pytest.approx(92.6 / 2.4477, rel=1e-3)  # 95 % of a circular Gaussian lies within 2.4477 sd
    assert sd[1] == pytest.approx(370.4 / 4.7985, rel=1e-3) and np.isnan(sd[2])
    np.testing.assert_allclose(found.rows["altitude_sd"].to_numpy(), [45 / 1.96, 150 / 1.96, np.nan])


def test_no_readable_time_is_an_error_that_shows_the_first_value():
    with pytest.raises(InputError, match=r"no time could be read in column 't' .*'noon'"):
        _measure({"t": ["noon", "later"], "lat": [1, 2], "lon": [1, 2]})
