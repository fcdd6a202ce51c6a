"""Round trips through other packages are exact to 1e-9, with the packages themselves."""

from __future__ import annotations

import sys
import warnings
from datetime import UTC, datetime, timedelta

import numpy as np
import polars as pl
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import jink
from jink.interop import czml, filter_py, geopandas, matlab, needed, stone_soup, stone_soup_filter, traffic

EXACT = {"rtol": 1e-9, "atol": 1e-9}
SENSOR = jink.Position(sd=15.0)
IMM = jink.IMM(
    [jink.ConstantVelocity(acceleration_psd=0.5), jink.ConstantAcceleration(jerk_psd=5.0)],
    SENSOR,
    jink.Sojourn([40, 20]),
)
OFFSETS = [0, 30, 50]


def measured(seed=0):
    rng = np.random.default_rng(seed)
    t = np.concatenate([np.round(np.cumsum(rng.uniform(1, 3, n)), 6) for n in (30, 20)])
    return t, np.column_stack([90.0 * t, 900.0 * np.sin(t / 15.0)]) + rng.normal(0, 15.0, (50, 2))


@pytest.fixture(scope="module")
def tracks():
    """Three flights on the map, with dates, one of them with gaps in its altitude."""
    rng = np.random.default_rng(1)
    rows = []
    for n, name in enumerate(("4ca1", "4ca2", "4ca3")):
        for k in range(40):
            t = datetime(2026, 5, 1, 12, tzinfo=UTC) + timedelta(seconds=5 * k, microseconds=int(rng.integers(1e6)))
            place = (50.0 + n + 0.005 * k + rng.normal(0, 1e-4), 8.0 + 0.004 * k + rng.normal(0, 1e-4))
            rows.append((name, t, *place, 9000.0 + rng.normal(0, 8.0)))
    table = pl.DataFrame(rows, schema=["target", "time", "latitude", "longitude", "altitude"], orient="row")
    return jink.track(table, details=True).tracks


def assert_tables_equal(got, want, columns):
    for name in columns:
        a, b = got[name], want[name]
        if b.dtype.is_float():
            assert_allclose(a.cast(float).to_numpy(), b.to_numpy(), **EXACT, err_msg=name)
        else:
            assert a.to_list() == b.to_list(), name


def test_stone_soup_tracks_go_out_and_come_back():
    soup = pytest.importorskip("stonesoup.types.track")
    t, z = measured()
    estimate = IMM.smooth(t, z, offsets=OFFSETS)
    tracks = stone_soup.tracks_of(estimate)
    assert [len(track) for track in tracks] == [30, 20] and isinstance(tracks[0], soup.Track)
    assert_allclose(np.asarray(tracks[1][-1].mean).ravel(), estimate.x[-1])
    back = stone_soup.estimate_of(tracks, estimate.components)
    for name in ("x", "P", "time"):
        assert_allclose(getattr(back, name), getattr(estimate, name), **EXACT)
    with pytest.raises(ValueError, match="components: expected 6 names"):
        stone_soup.estimate_of(tracks, ["px"])


def test_stone_soup_truth_and_detections_go_out_and_come_back():
    pytest.importorskip("stonesoup")
    t, z = measured()
    truth = np.column_stack([z[:, 0], 0 * t, z[:, 1], 0 * t])
    found = stone_soup.rows_of(stone_soup.paths_of(t, truth, OFFSETS))
    assert_array_equal(found.offsets, OFFSETS)
    assert found.covariance is None
    for got, want in ((found.time, t), (found.values, truth)):
        assert_allclose(got, want, **EXACT)
    noise = np.random.default_rng(0).uniform(100, 200, (50, 2))[:, :, None] * np.eye(2)
    missing = z.copy()
    missing[7] = np.nan
    detections = stone_soup.detections_of(t, missing, noise, OFFSETS)
    assert [len(each) for each in detections] == [29, 20]
    seen = stone_soup.rows_of(detections)
    kept = np.arange(50) != 7
    for got, want in ((seen.time, t[kept]), (seen.values, z[kept]), (seen.covariance, noise[kept])):
        assert_allclose(got, want, **EXACT)
    model = detections[0][0].measurement_model
    assert_allclose(np.asarray(model.matrix()), [[1, 0, 0, 0], [0, 0, 1, 0]])


@pytest.mark.parametrize("sensor", [SENSOR, jink.Polar(range_sd=20.0, azimuth_sd=0.003)])
def test_a_filter_as_stone_soups_predictor_and_updater(sensor):
    """The filter from a prior, run by Stone Soup's own objects, is the filter run by jink."""
    pytest.importorskip("stonesoup")
    from stonesoup.types.detection import Detection
    from stonesoup.types.hypothesis import SingleHypothesis
    from stonesoup.types.state import GaussianState

    motions = [jink.ConstantVelocity(acceleration_psd=q) for q in (0.1, 30.0)]
    filter = jink.IMM(motions, sensor, jink.Sojourn([40, 20]))
    t = np.arange(1.0, 20.0)
    place = np.column_stack([5000 + 90.0 * t, 8000 - 40.0 * t])
    z = place + np.random.default_rng(0).normal(0, 15, place.shape)
    if isinstance(sensor, jink.Polar):
        z = np.column_stack([np.hypot(*z.T), np.arctan2(z[:, 0], z[:, 1])])
    x, P = np.array([5000.0, 80.0, 8000.0, -30.0]), np.diag([1e4, 400.0, 1e4, 400.0])
    live = filter.start()
    live.begin(x, P, 0.0)
    predictor, updater = stone_soup_filter.pair(filter)
    dates = stone_soup.dates(t)
    state = GaussianState(x, P, timestamp=stone_soup.START)
    for k, when in enumerate(dates):
        prediction = predictor.predict(state, timestamp=when)
        ahead = live.predict(t[k])
        assert_allclose(np.asarray(prediction.mean).ravel(), ahead.x, **EXACT)
        detection = Detection(z[k], timestamp=when)
        expected = updater.predict_measurement(prediction)
        state = updater.update(SingleHypothesis(prediction, detection))
        now = live.update(t[k], z[k])
        assert_allclose(np.asarray(state.mean).ravel(), now.x, **EXACT)
        assert_allclose(np.asarray(state.covar), now.P, **EXACT)
        if isinstance(sensor, jink.Position):
            assert_allclose(np.asarray(expected.covar), ahead.P[::2, ::2] + sensor.noise, **EXACT)
    with pytest.raises(ValueError, match="prior: has 3 components; expected px, vx, py, vy"):
        predictor.predict(GaussianState(x[:3], P[:3, :3], timestamp=stone_soup.START), timestamp=dates[0])


def theirs(q, x, P):
    from filterpy.kalman import KalmanFilter

    one = KalmanFilter(dim_x=4, dim_z=2)
    one.F = np.kron(np.eye(2), [[1, 2.0], [0, 1]])
    one.Q = q * np.kron(np.eye(2), [[8 / 3, 2.0], [2.0, 2.0]])
    one.H, one.R = np.eye(4)[::2], 225.0 * np.eye(2)
    one.x, one.P = x.copy(), P.copy()
    return one


@pytest.mark.parametrize("several", [False, True])
def test_a_filterpy_filter_read_as_one_of_jink(several):
    pytest.importorskip("filterpy")
    from filterpy.kalman import IMMEstimator

    t, z = np.arange(30) * 2.0, measured(2)[1][:30]
    x, P = np.array([z[0, 0], 80.0, z[0, 1], 40.0]), np.diag([225.0, 900.0, 225.0, 900.0])
    model = theirs(0.5, x, P)
    if several:
        chain = np.array([[0.95, 0.05], [0.1, 0.9]])
        model = IMMEstimator([theirs(0.1, x, P), theirs(20.0, x, P)], [0.7, 0.3], chain)
    filter = filter_py.filter_of(model, 2.0)
    z[0] = np.nan
    estimate = filter.filter(t, z)
    assert filter.components == ("px", "vx", "py", "vy")
    for k in range(1, 30):
        model.predict()
        model.update(z[k])
        assert_allclose(estimate.x[k], np.ravel(model.x), **EXACT, err_msg=f"row {k}")
        assert_allclose(estimate.P[k], model.P, **EXACT)
        if several:
            assert_allclose(estimate.mode_probability[k], model.mu, **EXACT)
    with pytest.raises(ValueError, match=r"dt is 3 s; FilterPy's F and Q are for steps of 2 s"):
        filter.filter([0.0, 3.0], z[:2])


@pytest.mark.filterwarnings("ignore:The inplace keyword")  # of movingpandas beside pandas 3
def test_geopandas_points_and_movingpandas_trajectories(tracks):
    pytest.importorskip("movingpandas")
    points = geopandas.to_geodataframe(tracks)
    assert points.crs.to_epsg() == 4326 and len(points) == tracks.height
    names = ["target", "time", "latitude", "longitude", "altitude", "speed", "course", "status", "x_sd"]
    assert_tables_equal(geopandas.from_geodataframe(points), tracks.with_columns(pl.col("status").cast(str)), names)
    mercator = geopandas.from_geodataframe(points.to_crs("EPSG:3857"))
    assert_allclose(mercator["latitude"], tracks["latitude"], **EXACT)
    with pytest.raises(ValueError, match="no coordinate reference system"):
        geopandas.from_geodataframe(points.set_crs(None, allow_override=True))
    with pytest.raises(ValueError, match="have no latitude and longitude"):
        geopandas.to_geodataframe(tracks.drop("latitude", "longitude"))
    collection = geopandas.to_trajectories(tracks)
    assert len(collection.trajectories) == 3
    back = geopandas.from_trajectories(collection)
    assert_tables_equal(back, tracks, ["target", "time", "latitude", "longitude", "altitude", "speed"])
    assert jink.track(back.select("target", "time", "latitude", "longitude", "altitude")).height == tracks.height


def test_matlab_files(tracks, tmp_path):
    path = tmp_path / "tracks.mat"
    truth = pl.DataFrame({"time": [0.0, 0.5], "true_x": [1.0, None], "moving": [True, False], "scan": [0, 1]})
    local = tracks.with_columns(day=pl.col("time").dt.replace_time_zone(None))
    matlab.write_mat(path, tracks=local, truth=truth)
    found = matlab.read_mat(path)
    assert set(found) == {"tracks", "truth"} and found["tracks"].columns == local.columns
    assert_tables_equal(found["tracks"], local.with_columns(pl.col(pl.Enum).cast(str)), local.columns)
    assert found["truth"].equals(truth)
    with pytest.raises(ValueError, match="MATLAB takes no field called 'a b'"):
        matlab.write_mat(path, truth=truth.rename({"time": "a b"}))


def test_czml(tracks, tmp_path):
    czml.write_czml(tmp_path / "tracks.czml", tracks)
    back = czml.from_czml(tmp_path / "tracks.czml")
    assert_tables_equal(back, tracks, ["target", "time", "latitude", "longitude", "altitude"])
    packets = czml.to_czml(tracks)
    assert packets[0] == {"id": "document", "name": "jink", "version": "1.0"} and len(packets) == 4
    assert packets[1]["availability"].startswith("2026-05-01T12:00:0")
    seconds = tracks.with_columns(time=pl.col("time").dt.timestamp("us") / 1e6).drop("altitude")
    with pytest.raises(ValueError, match="times are no dates; expected start"):
        czml.to_czml(seconds)
    dated = czml.from_czml(czml.to_czml(seconds, start=datetime(1970, 1, 1, tzinfo=UTC)))
    assert dated["time"].to_list() == tracks["time"].to_list() and set(dated["altitude"]) == {0.0}


def test_traffic_columns_and_units(tracks):
    """The table that a Traffic holds, read as one and tracked again: altitudes and speeds in SI come back."""
    table = traffic.table_of(tracks)

    class Flights:
        data = table.to_pandas()

    back, columns = traffic.from_traffic(Flights)
    assert columns["altitude_ft"] == "altitude" and back["icao24"].to_list() == tracks["target"].to_list()
    assert_allclose(back["altitude"] * 0.3048, tracks["altitude"], **EXACT)
    assert_allclose(back["groundspeed"] * 1852 / 3600, tracks["speed"], **EXACT)
    again = jink.track(back, columns=columns, details=True)
    assert again.tracks.height == tracks.height
    assert_allclose(again.tracks["measured_z"].to_numpy(), tracks["altitude"].to_numpy(), rtol=1e-9)


def test_traffic_itself(tracks):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        core = pytest.importorskip("traffic.core", reason="traffic does not import here", exc_type=ImportError)
    flights = traffic.to_traffic(tracks)
    assert isinstance(flights, core.Traffic) and len(flights) == 3
    back, _ = traffic.from_traffic(flights)
    assert_allclose(back["latitude"], tracks["latitude"], **EXACT)


def test_a_package_that_is_missing_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "geopandas", None)
    with pytest.raises(ImportError, match=r"geopandas cannot be imported .*pip install 'jink\[interop\]'"):
        geopandas.to_geodataframe(pl.DataFrame())
    with pytest.raises(ImportError, match=r"pip install 'jink\[traffic\]'"):
        needed.needed("no_such_package", "traffic")
