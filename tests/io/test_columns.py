"""Which column is what, by the names of the trade, by units in names, and by the user's word."""

import math

import pytest

from jink.io.columns import normal, recognise
from jink.io.errors import InputError


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (
            "icao24 callsign timestamp latitude longitude altitude groundspeed",
            "icao24 timestamp latitude longitude altitude",
        ),
        ("time icao24 lat lon velocity heading baroaltitude geoaltitude", "icao24 time lat lon geoaltitude"),
        ("MMSI BaseDateTime LAT LON SOG COG", "MMSI BaseDateTime LAT LON -"),
        ("hex t lat lon alt_baro gs", "hex t lat lon alt_baro"),
        ("# Timestamp;MMSI;Latitude;Longitude", "MMSI,# Timestamp,Latitude,Longitude,-"),
        ("id;time_ms;Lat_deg;Lon_deg;Altitude (ft)", "id,time_ms,Lat_deg,Lon_deg,Altitude (ft)"),
    ],
)
def test_usual_names_are_recognised(names, expected):
    columns = recognise("f", names.split(";" if ";" in names else None))
    roles = ("target", "time", "latitude", "longitude", "altitude")
    found = [columns.roles[role].name if role in columns.roles else "-" for role in roles]
    assert found == expected.split("," if "," in expected else None)


def test_units_come_from_names():
    columns = recognise("f", ["track_id", "time_ms", "range [km]", "azimuth_deg", "Elevation (mrad)", "speed_kt"])
    units = {role: column.unit for role, column in columns.roles.items()}
    assert columns.position == "polar"
    assert units["time"] == 1e-3 and units["range"] == 1000.0 and units["elevation"] == 1e-3
    assert units["azimuth"] == pytest.approx(math.pi / 180) and units["speed"] == pytest.approx(0.514444, abs=1e-6)
    assert recognise("f", ["t", "x_nmi", "y_nmi", "z_ft"]).roles["z"].unit == 0.3048
    assert recognise("f", ["t", "lat", "lon", "alt_baro"]).roles["altitude"].unit == 0.3048
    assert recognise("f", ["t", "lat", "lon", "altitude"]).roles["altitude"].unit is None


def test_latitude_and_longitude_come_before_x_and_y_unless_told():
    names = ["t", "lat", "lon", "x", "y"]
    assert recognise("f", names).position == "geographic"
    assert recognise("f", names, {"x": "x", "y": "y"}).position == "cartesian"


def test_the_user_names_columns_with_units():
    columns = recognise(
        "f",
        ["a", "b", "c", "d", "e"],
        {"time_us": "a", "latitude": "b", "longitude": "c", "altitude_ft": "d"},
    )
    assert columns.named() == {"time": "a", "latitude": "b", "longitude": "c", "altitude": "d"}
    assert columns.roles["time"].unit == 1e-6 and columns.roles["altitude"].unit == 0.3048


def test_errors_list_what_was_found_and_what_was_looked_for():
    with pytest.raises(InputError) as caught:
        recognise("plots.csv", ["when", "bredd", "langd"])
    message = str(caught.value)
    assert all(word in message for word in ("plots.csv", "when, bredd, langd", "latitude: latitude, lat", "--columns"))
    with pytest.raises(InputError, match=r"a time column is needed.*\n.*Found: lat, lon"):
        recognise("f", ["lat", "lon"])
    with pytest.raises(InputError, match="did you mean 'latt'"):
        recognise("f", ["t", "latt", "lon"], {"latitude": "lat_t"})
    with pytest.raises(InputError, match="'height_ft' is not known"):
        recognise("f", ["t", "lat", "lon"], {"height_ft": "t"})


def test_names_are_compared_without_case_and_punctuation():
    assert (
        normal("Range [km]") == "range_km"
        and normal("  # Timestamp") == "timestamp"
        and normal("Azimut (°)") == "azimut_deg"
    )
