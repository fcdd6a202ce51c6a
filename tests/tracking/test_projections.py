"""x and y of map projections, and azimuths from grid north."""

from __future__ import annotations

import numpy as np
import pytest
from pyproj import Geod, Proj, Transformer
from straight import Journey

import jink
from jink.io.errors import InputError

NORTH = Journey(latitude=60.0, longitude=10.7)
PLANE = Journey(speed=230.0, course=100.0, latitude=49.0)


def table(path, code: str, header: str = "id,time,x,y", more=lambda i: "") -> None:
    forth = Transformer.from_crs("EPSG:4326", code, always_xy=True)
    lines = [header]
    for i, (time, (lat, lon)) in enumerate(zip(NORTH.times, NORTH.places, strict=True)):
        x, y = forth.transform(lon, lat)
        lines.append(f"1,{time:%Y-%m-%dT%H:%M:%SZ},{x:.3f},{y:.3f}{more(i)}")
    path.write_text("\n".join(lines) + "\n")


@pytest.mark.parametrize("code", ["EPSG:3857", "EPSG:32633", "EPSG:2225"])
def test_coordinates_of_a_projection_become_places(tmp_path, code):
    """UTM's zone is not that of the place, so grid north is 3.7 degrees off; EPSG:2225 counts in feet."""
    journey = NORTH if code != "EPSG:2225" else Journey(latitude=40.0, longitude=-122.0)
    forth = Transformer.from_crs("EPSG:4326", code, always_xy=True)
    lines = ["id,time,x,y"]
    for time, (lat, lon) in zip(journey.times, journey.places, strict=True):
        lines.append("1,{:%Y-%m-%dT%H:%M:%SZ},{:.3f},{:.3f}".format(time, *forth.transform(lon, lat)))
    (tmp_path / "x.csv").write_text("\n".join(lines) + "\n")
    tracks, rejected, _ = jink.track(tmp_path / "x.csv", kind="vehicle", crs=code, details=True)
    journey.agrees(tracks)
    assert not rejected.height
    assert tracks["latitude"][0] == pytest.approx(journey.latitude, abs=1e-5)


def test_web_mercator_is_told_by_the_reported_speed(tmp_path):
    table(tmp_path / "x.csv", "EPSG:3857", "id,time,x,y,speed", lambda i: ",20.0")
    tracks, _, summary = jink.track(tmp_path / "x.csv", kind="vehicle", details=True)
    NORTH.agrees(tracks)
    assert any("(Web Mercator)" in note and "takes metres" in note for note in summary["notes"])
    plain, _, _ = jink.track(tmp_path / "x.csv", kind="vehicle", columns={"x": "x", "y": "y"}, details=True)
    assert plain["speed"].median() == pytest.approx(40.0, rel=0.02)


def test_large_coordinates_of_an_open_projection_are_spoken_of(tmp_path):
    table(tmp_path / "x.csv", "EPSG:32632")
    tracks, _, summary = jink.track(tmp_path / "x.csv", kind="vehicle", details=True)
    assert tracks["speed"].median() == pytest.approx(20.0, rel=0.01)
    assert any("--crs EPSG:3857" in note for note in summary["notes"])


def test_places_of_postgis_say_their_projection(tmp_path):
    forth = Transformer.from_crs("EPSG:4326", "EPSG:3857", always_xy=True)
    lines = ["id;time;geom"]
    for time, (lat, lon) in zip(NORTH.times, NORTH.places, strict=True):
        x, y = forth.transform(lon, lat)
        lines.append(f'1;{time:%Y-%m-%dT%H:%M:%SZ};"SRID=3857;POINT({x:.3f} {y:.3f})"')
    (tmp_path / "x.csv").write_text("\n".join(lines) + "\n")
    tracks, _, _ = jink.track(tmp_path / "x.csv", kind="vehicle", details=True)
    NORTH.agrees(tracks)


def test_velocities_along_the_grid_turn_with_it(tmp_path):
    """20 m/s at 60 degrees from true north, in a zone whose north is 3.7 degrees off."""
    off = Proj("EPSG:32633").get_factors(10.7, 60.0).meridian_convergence
    course = np.radians(60.0 - off)
    more = f",{20.0 * np.sin(course):.4f},{20.0 * np.cos(course):.4f}"
    table(tmp_path / "x.csv", "EPSG:32633", "id,time,x,y,vx,vy", lambda i: more)
    tracks, _, summary = jink.track(tmp_path / "x.csv", kind="vehicle", crs="EPSG:32633", details=True)
    NORTH.agrees(tracks)
    assert not any("velocity is not used: it is" in note for note in summary["notes"])


@pytest.mark.parametrize(("code", "zone"), [(None, "EPSG:32631"), ("EPSG:32633", "EPSG:32633")])
def test_azimuths_from_grid_north(tmp_path, code, zone):
    site = 49.3, 5.9, 100.0
    geod = Geod(ellps="WGS84")
    off = Proj(zone).get_factors(site[1], site[0]).meridian_convergence
    rows = ["id,time,range,azimuth_deg,altitude"]
    for time, (lat, lon) in zip(PLANE.times, PLANE.places, strict=True):
        azimuth, _, ground = geod.inv(site[1], site[0], lon, lat)
        slant = np.hypot(ground, 10_000.0)
        rows.append(f"1,{time:%Y-%m-%dT%H:%M:%SZ},{slant:.2f},{(azimuth - off) % 360.0:.5f},10100")
    (tmp_path / "x.csv").write_text("\n".join(rows) + "\n")
    tracks, _, summary = jink.track(tmp_path / "x.csv", site=site, azimuth_from="grid", crs=code, details=True)
    assert abs(off) > 2.0
    course = np.degrees(tracks["course"].drop_nulls().to_numpy())[-10:].mean()
    assert course == pytest.approx(100.5, abs=0.7)
    assert tracks["latitude"][0] == pytest.approx(49.0, abs=0.005)
    assert any(zone in note and "from true north" in note for note in summary["notes"])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"azimuth_from": "grid"}, "need one --site"),
        ({"crs": "EPSG:99999", "azimuth_from": "north"}, "expected a projection that pyproj knows"),
        ({"crs": "EPSG:4326"}, "has no x and y"),
        ({"azimuth_from": "south"}, "'north' or 'east' or 'grid'"),
    ],
)
def test_what_has_no_grid_is_refused(tmp_path, options, message):
    table(tmp_path / "x.csv", "EPSG:32632")
    with pytest.raises(InputError, match=message):
        jink.track(tmp_path / "x.csv", kind="vehicle", **options)


def test_a_projection_of_latitudes_is_refused(tmp_path):
    (tmp_path / "x.csv").write_text("\n".join(["id,time,lat,lon", *NORTH.lines("1,{t},{lat:.6f},{lon:.6f}")]) + "\n")
    with pytest.raises(InputError, match="is for x and y"):
        jink.track(tmp_path / "x.csv", crs="EPSG:3857")
