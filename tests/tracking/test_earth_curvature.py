"""Altitudes of a radar's plots are above the curved earth: the native sensor, and a flight seen from far away."""

from __future__ import annotations

import numpy as np
import polars as pl
import pytest
from oracle import sensor as textbook

import jink
from jink._engine import native
from jink.io.geodesy import SiteFrame
from jink.tracking import prepare

RADIUS = 6.38e6
SITE = (48.0, 9.0, 500.0)
SITES = [(0.0, 0.0, 0.0), (3000.0, -2000.0, 40.0)]


def points(n=200, seed=0):
    rng = np.random.default_rng(seed)
    return np.c_[rng.uniform(-3e5, 3e5, (n, 2)), rng.uniform(-2000.0, 12_000.0, n)]


@pytest.mark.parametrize("site", SITES)
def test_height_and_its_slopes_equal_the_textbook(site):
    sensor = jink.Polar(range_sd=30.0, azimuth_sd=1e-3, height_sd=20.0, site=site, earth_radius=RADIUS)
    want = textbook.Polar(30.0, 1e-3, height_sd=20.0, site=site, earth_radius=RADIUS)
    x = np.zeros((200, 6))
    x[:, ::2] = points()
    h, H = native.observe_sensor(sensor.native(), x)
    for k, p in enumerate(points()):
        np.testing.assert_allclose(h[k], want.h(p, np.zeros(3)), rtol=1e-12, atol=1e-7)
        np.testing.assert_allclose(H[k][:, ::2], want.H(p, np.zeros(3))[0], rtol=1e-11, atol=1e-14)


@pytest.mark.parametrize("site", SITES)
def test_the_way_back_from_slant_range_and_height(site):
    """The place of a plot without noise, by the sensor, by the engine's start and by the textbook's bisection."""
    sensor = jink.Polar(range_sd=1e-3, azimuth_sd=1e-9, height_sd=1e-3, site=site, earth_radius=RADIUS)
    want = textbook.Polar(1e-3, 1e-9, height_sd=1e-3, site=site, earth_radius=RADIUS)
    p = points()
    z = np.array([want.h(one, np.zeros(3)) for one in p])
    np.testing.assert_allclose(sensor.positions(z), p, atol=2e-3)
    R = np.tile(want.R, (len(p), 1, 1))
    fix = native.position_of(sensor.native(), z, R, np.ones(z.shape, bool))
    np.testing.assert_allclose(fix[2], p, atol=2e-3)
    for k in range(0, len(p), 10):
        np.testing.assert_allclose(want.fix(z[k], want.R)[0], fix[2][k], atol=2e-3)


def test_without_a_radius_height_is_above_the_plane():
    flat = jink.Polar(range_sd=30.0, azimuth_sd=1e-3, height_sd=20.0)
    x = np.zeros((200, 6))
    x[:, ::2] = points()
    np.testing.assert_array_equal(native.observe_sensor(flat.native(), x)[0][:, 2], x[:, 4])
    with pytest.raises(ValueError, match="earth_radius bends the height"):
        jink.Polar(range_sd=30.0, azimuth_sd=1e-3, earth_radius=RADIUS)
    with pytest.raises(ValueError, match="earth_radius"):
        jink.Polar(range_sd=30.0, azimuth_sd=1e-3, height_sd=20.0, earth_radius=-1.0)


def test_the_radius_of_a_site_fits_the_ellipsoid():
    """Points at one altitude around a site lie within centimetres of the sphere, out to 50 km."""
    site = SiteFrame(*SITE)
    east, north = np.meshgrid(np.linspace(-5e4, 5e4, 11), np.linspace(-5e4, 5e4, 11))
    up = -(east**2 + north**2) / (2 * site.earth_radius)
    *_, altitude = site.to_geographic(east.ravel(), north.ravel(), up.ravel())
    assert np.abs(altitude - 500.0).max() < 1.5  # 0.3 % of the 390 m of curvature at 70 km


def far_flight(first, noise, site=SITE, to=20.0):
    """A flight on a geodesic at 11 km, from `first` metres north of the site outwards, as an exact radar sees it."""
    from pyproj import Geod, Transformer

    geod, space = Geod(ellps="WGS84"), Transformer.from_pipeline("+proj=cart +ellps=WGS84")
    n = 80
    start = geod.fwd(site[1], site[0], to, first)
    track = [geod.fwd(start[0], start[1], 60.0, 230.0 * 4.0 * k) for k in range(n)]
    lon, lat = np.array([t[0] for t in track]), np.array([t[1] for t in track])
    altitude = np.full(n, 11_000.0)
    target = np.array(space.transform(lon, lat, altitude))
    origin = np.array(space.transform(site[1], site[0], site[2]))[:, None]
    phi, lam = np.radians(site[0]), np.radians(site[1])
    to_enu = np.array(
        [
            [-np.sin(lam), np.cos(lam), 0.0],
            [-np.sin(phi) * np.cos(lam), -np.sin(phi) * np.sin(lam), np.cos(phi)],
            [np.cos(phi) * np.cos(lam), np.cos(phi) * np.sin(lam), np.sin(phi)],
        ]
    )
    e, nn, u = to_enu @ (target - origin)
    rng = np.random.default_rng(3)
    slant = np.sqrt(e * e + nn * nn + u * u) + noise * rng.normal(size=n)
    azimuth = np.degrees(np.arctan2(e, nn)) % 360
    table = pl.DataFrame(
        {"id": ["a"] * n, "time": np.arange(n) * 4.0, "range": slant, "azimuth_deg": azimuth, "altitude": altitude}
    )
    return table, lat, lon


@pytest.mark.parametrize("first", [60e3, 200e3, 320e3])
def test_a_far_flight_is_where_it_is(first):
    """Without curvature, height taken as z put the range off by 15 to 180 m; now the mean error is below 3 m."""
    from pyproj import Geod

    table, lat, lon = far_flight(first, noise=1.0)
    tracks = jink.track(table, site=SITE, sensor_sd={"range": 1.0, "azimuth_deg": 0.001, "altitude": 8.0})
    *_, off = Geod(ellps="WGS84").inv(tracks["longitude"], tracks["latitude"], lon, lat)
    assert np.mean(off[10:]) < 3.0
    assert np.abs(tracks["altitude"].to_numpy()[10:] - 11_000.0).max() < 20.0


@pytest.mark.parametrize("to", [0.0, 90.0])
@pytest.mark.parametrize("site", [(0.0, 179.9, 30.0), (47.0, 8.0, 2500.0), (-89.9, 0.0, 2800.0)])
def test_altitudes_are_above_the_ellipsoid_in_every_direction(site, to):
    """The sphere of a site is up to 24 m off at 300 km, and the altitude in the output was so too."""
    table, *_ = far_flight(300e3, noise=1.0, site=site, to=to)
    tracks = jink.track(table, site=site, sensor_sd={"range": 1.0, "azimuth_deg": 0.001, "altitude": 8.0})
    assert np.abs(tracks["altitude"].to_numpy() - 11_000.0).max() < 2.0


def test_a_stream_knows_how_high_its_radar_stands():
    """Altitudes were taken for heights above the site: those of the output were higher by its own."""
    site = (47.0, 8.0, 2500.0)
    table, *_ = far_flight(100e3, noise=1.0, site=site)
    how = {"site": site, "sensor_sd": {"range": 50.0, "azimuth_deg": 0.1, "altitude": 10.0}}
    tracks = jink.track(table, **how)
    live = jink.LiveTracker(**how)
    rows = [live.update(row["id"], row["time"], **{n: row[n] for n in table.columns[2:]}) for row in table.to_dicts()]
    for name in ("latitude", "longitude", "altitude", "z", "measured_z"):
        np.testing.assert_allclose([row[name] for row in rows], tracks[name].to_numpy(), rtol=1e-9)
    assert abs(rows[-1]["altitude"] - 11_000.0) < 5.0


@pytest.mark.parametrize("third", ["altitude", "elevation_deg"])
@pytest.mark.parametrize("some", [False, True], ids=["all", "some"])
def test_plots_without_identity_use_their_heights(third, some):
    """Altitudes were left out, and slant ranges taken along the ground: positions were 400 m off at 170 km."""
    from pyproj import Geod

    table, lat, lon = far_flight(170e3, noise=20.0)
    radius, slant = SiteFrame(*SITE).earth_radius, table["range"]
    high = radius + 11_000.0 - SITE[2]
    table = table.with_columns(
        elevation_deg=((high**2 - radius**2 - slant**2) / (2 * radius * slant)).arcsin().degrees()
    )
    known = np.arange(table.height) % 3 > 0 if some else np.ones(table.height, bool)
    table = table.select("time", "range", "azimuth_deg", pl.when(pl.Series(known)).then(pl.col(third)).alias(third))
    sd = {"range": 20.0, "azimuth_deg": 0.01, "altitude": 8.0, "elevation_deg": 0.01}
    found = jink.track(table, site=SITE, sensor_sd=sd, anonymous={"detection": 0.95, "period": 4.0}, details=True)
    assert any("without heights" in note for note in found.summary["notes"]) == some
    tracks = found.tracks.filter(pl.col("row").is_not_null())
    rows = tracks["row"].to_numpy()
    *_, off = Geod(ellps="WGS84").inv(tracks["longitude"], tracks["latitude"], lon[rows], lat[rows])
    assert np.median(off) < 30.0
    assert ("altitude" in tracks.columns) == (not some)


@pytest.mark.parametrize(("far", "height", "said"), [(2e5, False, True), (5e4, False, False), (2e5, True, False)])
def test_it_is_said_what_x_and_y_far_from_a_site_are_taken_for(far, height, said):
    t = np.arange(40.0)
    rng = np.random.default_rng(3)
    data = pl.DataFrame({"target": ["a"] * 40, "time": t, "x_m": far + 200.0 * t, "y_m": rng.normal(0.0, 30.0, 40)})
    data = data.with_columns(x_m=pl.col("x_m") + rng.normal(0.0, 30.0, 40))
    data = data.with_columns(z_m=9000.0 + rng.normal(0.0, 30.0, 40)) if height else data
    notes = jink.track(data, site=(48.0, 11.0, 500.0), details=True).summary["notes"]
    assert any("x and y without z are taken along the ground" in note for note in notes) == said


def test_it_is_said_once_where_some_targets_tell_for_all(monkeypatch):
    monkeypatch.setattr(prepare, "EVIDENCE", 50)
    t, rng = np.tile(np.arange(40.0), 2), np.random.default_rng(3)
    data = pl.DataFrame({"target": np.repeat(["a", "b"], 40), "time": t, "x_m": 2e5 + 200.0 * t, "y_m": np.zeros(80)})
    data = data.with_columns(pl.col("x_m", "y_m") + pl.Series(rng.normal(0.0, 30.0, 80)))
    notes = jink.track(data, site=(48.0, 11.0, 500.0), details=True).summary["notes"]
    assert sum("x and y without z are taken along the ground" in note for note in notes) == 1


@pytest.mark.parametrize("where", [{}, {"site": SITE}, {"site": SITE, "anonymous": {"period": 4.0}}])
def test_a_level_flight_says_nothing_of_the_noise_of_heights(where):
    rng, time = np.random.default_rng(0), 4.0 * np.arange(120)
    east, north = 40e3 + 0.0 * time, 200.0 * time - 40e3
    plots = pl.DataFrame(
        {
            "target": "level",
            "time": time,
            "slant_range": np.sqrt(east**2 + north**2 + 10_168.0**2) + rng.normal(0, 40.0, time.size),
            "azimuth_deg": np.degrees(np.arctan2(east, north)) + rng.normal(0, 0.05, time.size),
            "altitude": 10_668.0,
        }
    )
    noise = jink.track(plots, details=True, **where).summary["noise"][0]
    assert noise["altitude_sd"] >= 10.0
