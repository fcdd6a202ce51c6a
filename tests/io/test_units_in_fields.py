"""Fields that tell their own unit are read by that, and what becomes of the others is said."""

from __future__ import annotations

import numpy as np
import polars as pl
import pytest

import jink

FOOT = 0.3048


def heights(fields: list[str], name: str = "altitude", **how) -> tuple[np.ndarray, str]:
    """Altitudes that are read (m; NaN: missing), and the notes."""
    count = len(fields)
    table = {"id": "a", "time": np.arange(count), "lat": 50.0 + 1e-3 * np.arange(count), "lon": 8.0, name: fields}
    tracks, _, summary = jink.track(pl.DataFrame(table), details=True, check_coordinates=False, **how)
    return tracks["measured_z"].fill_null(np.nan).to_numpy(), "\n".join(summary["notes"])


@pytest.mark.parametrize(
    ("fields", "name", "metres", "said"),
    [
        (["35,000 ft"] * 20, "altitude", [35_000 * FOOT], "has its unit in every field (ft)"),
        (["FL350"] * 20, "altitude", [35_000 * FOOT], ""),
        (
            ["1200 ft", "1300", "1300"] * 8,
            "altitude",
            [1200 * FOOT, 1300 * FOOT],
            "8 of 24 fields (ft); the others are taken as ft",
        ),
        (
            ["1200 ft", "400", "400"] * 8,
            "altitude_m",
            [1200 * FOOT, 400.0],
            "the others have that of the column's name",
        ),
        (
            ["1200 ft", "1200 ft", "400"] * 8,
            "altitude",
            [1200 * FOOT, 1200 * FOOT, np.nan],
            "16 of 24 fields (ft); the others are left out",
        ),
        (
            ["FL50", "4500", "4500"] * 8,
            "altitude",
            [5000 * FOOT, 4500 * FOOT],
            "8 of 24 fields (FL); the others are taken as ft",
        ),
        (["FL50", "4500", "4500"] * 8, "altitude_ft", [5000 * FOOT, 4500 * FOOT], "8 of 24 fields (FL)"),
        (
            ["FL50", "FL50", "4500"] * 8,
            "altitude",
            [5000 * FOOT, 5000 * FOOT, np.nan],
            "16 of 24 fields (FL); the others are left out",
        ),
        (["FL50", "4500 ft"] * 8, "altitude", [5000 * FOOT, 4500 * FOOT], "in every field (FL, ft)"),
        (
            ["1200 ft", "1200 ft", "400 agl"] * 8,
            "altitude",
            [1200 * FOOT, 1200 * FOOT, np.nan],
            "8 unreadable fields in column 'altitude'",
        ),
    ],
)
def test_heights_have_the_unit_of_their_field(fields, name, metres, said):
    found, notes = heights(fields, name)
    np.testing.assert_allclose(found[: len(metres)], metres, rtol=1e-9)
    assert said in notes
    # the option is for fields that tell no unit
    np.testing.assert_array_equal(heights(fields, name, altitude_unit="ft")[0], found)


def rows_of(x: list[str]) -> tuple[list[float], list[str]]:
    """The x that is tracked, and the reasons of rejected rows."""
    table = pl.DataFrame({"id": "a", "time": np.arange(len(x)), "x": x, "y": 0.0})
    tracks, rejected, _ = jink.track(table, details=True, check_coordinates=False, min_points=1)
    return tracks["measured_x"].to_list(), rejected["reason"].to_list()


@pytest.mark.parametrize(
    ("fields", "metres"),
    [
        (["950.5", "1,000.5", "1,050", "1,234,567.0"], [950.5, 1000.5, 1050.0, 1234567.0]),
        (["950,5", "1.000,5", "1.050", "1.234.567,0"], [950.5, 1000.5, 1050.0, 1234567.0]),
        (["-9,5", "1000,5", "1,050", "3"], [-9.5, 1000.5, 1.05, 3.0]),
    ],
)
def test_separators_of_thousands_are_read_where_a_field_tells_them(fields, metres):
    found, reasons = rows_of(fields * 3)
    np.testing.assert_allclose(found, metres * 3, rtol=1e-12)
    assert not reasons


@pytest.mark.parametrize("others", [["950.5", "960.25"], ["950", "960"]])
def test_a_comma_that_may_be_either_is_said_to_be_that(others):
    _, reasons = rows_of([*others, "1,000"] * 4)
    assert reasons == ["x has a comma that is a decimal one or one between thousands"] * 4


def test_positions_have_the_unit_of_their_field():
    found, reasons = rows_of(["100 ft", "1 km", "200 ft"] * 4)
    np.testing.assert_allclose(found, [100 * FOOT, 1000.0, 200 * FOOT] * 4, rtol=1e-12)
    # a field without a unit, where most have one, is no position
    found, reasons = rows_of(["100 ft", "150", "200 ft", "300 agl"] * 4)
    np.testing.assert_allclose(found, [100 * FOOT, 200 * FOOT] * 4, rtol=1e-12)
    assert sorted(set(reasons)) == ["x has no unit, as others have", "x is not a number"] and len(reasons) == 8


@pytest.mark.parametrize("unit", ["°", " deg"])
def test_small_angles_that_say_degrees_are_not_radians(unit):
    degrees = 1.0 + 0.1 * np.arange(20)
    table = {"id": "a", "time": np.arange(20), "range": 1e4, "azimuth": [f"{value:.1f}{unit}" for value in degrees]}
    tracks = jink.track(pl.DataFrame(table), check_coordinates=False, target_height="ground")
    np.testing.assert_allclose(tracks["measured_x"], 1e4 * np.sin(np.radians(degrees)), rtol=1e-9)
