"""Two radars that see the same aircraft from their own sites, in one table or in a file each."""

import numpy as np
import polars as pl
import pytest
from pyproj import Geod, Transformer

import jink
from jink.cli.main import app
from jink.io.errors import InputError

SITES = {"north": (49.0, 11.0, 500.0), "south": (47.8, 12.5, 900.0)}
RANGE_SD, ANGLE_SD = 40.0, 1.5e-3


def _seen_from(site, latitude, longitude, altitude):
    """Range, azimuth and elevation of places: straight lines over the ellipsoid, by rotation of Earth-fixed axes."""
    cart = Transformer.from_pipeline("+proj=cart +ellps=WGS84")
    there = np.array(cart.transform(longitude, latitude, altitude))
    here = np.array(cart.transform(site[1], site[0], site[2]))
    phi, lam = np.radians(site[0]), np.radians(site[1])
    d = there - here[:, None]
    east = -np.sin(lam) * d[0] + np.cos(lam) * d[1]
    north = -np.sin(phi) * np.cos(lam) * d[0] - np.sin(phi) * np.sin(lam) * d[1] + np.cos(phi) * d[2]
    up = np.cos(phi) * np.cos(lam) * d[0] + np.cos(phi) * np.sin(lam) * d[1] + np.sin(phi) * d[2]
    return np.sqrt((d**2).sum(axis=0)), np.arctan2(east, north), np.arctan2(up, np.hypot(east, north))


@pytest.fixture(scope="module")
def plots():
    """An aircraft that flies straight at 230 m/s and 9 km, seen by both every 4 s, two seconds apart."""
    rng = np.random.default_rng(8)
    time = np.arange(0.0, 600.0, 2.0)
    count = time.size
    longitude, latitude, _ = Geod(ellps="WGS84").fwd(
        np.full(count, 10.5), np.full(count, 48.2), np.full(count, 70.0), 230.0 * time
    )
    tables = []
    for number, (name, site) in enumerate(SITES.items()):
        mine = slice(number, None, 2)
        distance, azimuth, elevation = _seen_from(site, latitude[mine], longitude[mine], np.full(count, 9000.0)[mine])
        size = distance.size
        tables.append(
            pl.DataFrame(
                {
                    "target": "plane",
                    "radar": name,
                    "time": time[mine],
                    "range": distance + RANGE_SD * rng.normal(size=size),
                    "azimuth_deg": np.degrees(azimuth + ANGLE_SD * rng.normal(size=size)),
                    "elevation_deg": np.degrees(elevation + ANGLE_SD * rng.normal(size=size)),
                    "true_latitude": latitude[mine],
                    "true_longitude": longitude[mine],
                }
            )
        )
    return pl.concat(tables).sort("time")


def _metres_off(tracks, plots):
    rows = plots[tracks["row"].to_numpy()]
    _, _, length = Geod(ellps="WGS84").inv(
        tracks["longitude"].to_numpy(),
        tracks["latitude"].to_numpy(),
        rows["true_longitude"].to_numpy(),
        rows["true_latitude"].to_numpy(),
    )
    return length


def test_plots_of_several_sites_make_one_track(plots):
    tracks, rejected, summary = jink.track(plots, site=SITES, details=True)
    assert not rejected.height
    assert tracks["part"].n_unique() == 1
    off = _metres_off(tracks, plots)[20:]
    alone = plots.filter(pl.col("radar") == "north")
    single = _metres_off(jink.track(alone, site=SITES["north"]), alone)[10:]
    assert np.sqrt((off**2).mean()) < 0.8 * np.sqrt((single**2).mean())
    assert tracks["speed"].to_numpy()[50:].mean() == pytest.approx(230.0, rel=0.01)
    # 9 km above the ellipsoid
    assert tracks["altitude"].to_numpy()[50:].mean() == pytest.approx(9000.0, abs=60.0)
    notes = [note for note in summary["notes"] if note.startswith(("north at", "south at"))]
    assert len(notes) == 2
    assert all("azimuth 1.5 mrad (estimated)" in note or "azimuth 1.4" in note or "1.6" in note for note in notes)
    assert summary["consistency"]["inside_95"] > 0.85
    assert 0.7 < summary["consistency"]["mean_per_dimension"] < 1.3


def test_a_file_of_each_radar_at_the_command_line(plots, tmp_path):
    for name, rows in plots.partition_by("radar", as_dict=True).items():
        rows.drop("radar").write_csv(tmp_path / f"{name[0]}.csv")
    sites = [item for name, site in SITES.items() for item in ("--site", f"{name}={','.join(map(str, site))}")]
    out = tmp_path / "out.parquet"
    with pytest.raises(SystemExit) as ended:
        app(["track", str(tmp_path / "north.csv"), str(tmp_path / "south.csv"), *sites, "-o", str(out), "-q"])
    assert ended.value.code in (0, None)
    found = pl.read_parquet(out)
    assert (found.height, found["part"].n_unique()) == (plots.height, 1)
    truth = plots.sort("time")
    assert np.abs(found.sort("time")["latitude"] - truth["true_latitude"])[20:].max() < 0.005


def test_sites_that_do_not_fit_the_table(plots):
    with pytest.raises(InputError, match="no site is given for 'south'; given are north"):
        jink.track(plots, site={"north": SITES["north"]})
    with pytest.raises(InputError, match="no column says which radar measured"):
        jink.track(plots.drop("radar"), site=SITES)
    flat = pl.DataFrame({"time": np.arange(9.0), "x": np.arange(9.0) * 99, "y": np.arange(9.0)})
    with pytest.raises(InputError, match="sites by name are for range and azimuth"):
        jink.track(flat, site=SITES)


@pytest.mark.parametrize(
    "given", [["a=48,11", "48,12"], ["48,11", "48,12"], ["a=48,11", "a=48,12"], ["a=x"], ["95,11"]]
)
def test_sites_that_make_no_sense(given, tmp_path, capsys):
    (tmp_path / "a.csv").write_text("time,range,azimuth_deg\n1,2,3\n")
    with pytest.raises(SystemExit) as ended:
        app(["track", str(tmp_path / "a.csv"), *(item for site in given for item in ("--site", site))])
    assert ended.value.code == 2
    assert "--site is" in capsys.readouterr().err


@pytest.fixture(scope="module")
def of_several_heights():
    """Four aircraft at 2 to 11 km past two radars, with the heights that the plots report, and where they truly are."""
    rng, geod = np.random.default_rng(2), Geod(ellps="WGS84")
    time = np.arange(0.0, 400.0, 2.0)
    tables = []
    for number, height in enumerate((2000.0, 5000.0, 8000.0, 11000.0)):
        start, course = 11.2 + 0.2 * number, 40.0 + 70.0 * number
        longitude, latitude, _ = geod.fwd(
            np.full(time.size, start), np.full(time.size, 48.4), np.full(time.size, course), 150.0 * time
        )
        for k, (name, site) in enumerate(SITES.items()):
            mine = slice(k, None, 2)
            size = time[mine].size
            distance, azimuth, _ = _seen_from(site, latitude[mine], longitude[mine], np.full(size, height))
            columns = {
                "target": str(number),
                "radar": name,
                "time": time[mine],
                "range": distance + RANGE_SD * rng.normal(size=size),
                "azimuth_deg": np.degrees(azimuth + ANGLE_SD * rng.normal(size=size)),
                "altitude_m": height + 8.0 * rng.normal(size=size),
                "true_latitude": latitude[mine],
                "true_longitude": longitude[mine],
            }
            tables.append(pl.DataFrame(columns))
    return pl.concat(tables).sort("time")


def _share_inside(found, plots):
    """The share of positions within two standard deviations along east and north, and the RMS error in metres."""
    tracks = found.tracks.filter(pl.col("status") == "updated")
    rows = plots[tracks["row"].to_numpy()]
    azimuth, _, length = Geod(ellps="WGS84").inv(
        *(rows[f"true_{name}"].to_numpy() for name in ("longitude", "latitude")),
        *(tracks[name].to_numpy() for name in ("longitude", "latitude")),
    )
    off = np.column_stack([length * np.sin(np.radians(azimuth)), length * np.cos(np.radians(azimuth))])
    inside = np.abs(off) <= 2.0 * tracks.select("x_sd", "y_sd").to_numpy()
    return inside.mean(), np.sqrt((length**2).mean())


def test_plots_without_a_height_lie_at_that_of_their_target(of_several_heights):
    """A plot without its height was put at the height of the radar, with a noise of 1 m."""
    plots = of_several_heights
    rng = np.random.default_rng(3)
    some = plots.with_columns(
        altitude_m=pl.when(pl.Series(rng.random(plots.height) < 0.3)).then(None).otherwise("altitude_m")
    )
    _, whole = _share_inside(jink.track(plots, site=SITES, details=True), plots)
    found = jink.track(some, site=SITES, details=True)
    share, off = _share_inside(found, plots)
    assert share > 0.93
    assert off < 1.1 * whole
    assert not found.summary["warnings"]
    # what was not measured is not said to be
    unseen = some.with_row_index("row").filter(pl.col("altitude_m").is_null())["row"]
    assert found.tracks.filter(pl.col("row").is_in(unseen.implode()))["measured_z"].null_count() == len(unseen)


def test_a_radar_without_heights_takes_those_of_the_other(of_several_heights):
    plots = of_several_heights
    some = plots.with_columns(altitude_m=pl.when(pl.col("radar") == "south").then(None).otherwise("altitude_m"))
    share, off = _share_inside(jink.track(some, site=SITES, details=True), plots)
    assert share > 0.93
    assert off < 1.1 * _share_inside(jink.track(plots, site=SITES, details=True), plots)[1]


def test_targets_without_heights_are_as_uncertain_as_that_makes_them(of_several_heights):
    """Several sites knew neither slant ranges nor a given height: positions were 0.5 km off, with an sd of 50 m."""
    plots = of_several_heights
    flat = plots.drop("altitude_m").rename({"range": "slant_range"})
    found = jink.track(flat, site=SITES, target_height="6500,3500", details=True)
    assert any("targets are taken to be 6500 ± 3500 m above" in note for note in found.summary["notes"])
    share, off = _share_inside(found, plots)
    ground = jink.track(flat, site=SITES, target_height="ground", details=True)
    assert share > 0.9
    assert off < 0.5 * _share_inside(ground, plots)[1]
    assert found.summary["consistency"]["inside_95"] > 0.9
    usual = jink.track(flat, site=SITES, details=True).summary["notes"]
    assert any("slant ranges without heights: targets are taken to be 3000 ± 2500 m" in note for note in usual)
    # one target among others has none
    alone = plots.with_columns(altitude_m=pl.when(pl.col("target") == "1").then(None).otherwise("altitude_m"))
    found = jink.track(alone, site=SITES, details=True)
    assert any("slant ranges without heights" in note for note in found.summary["notes"])
    assert _share_inside(found, plots)[0] > 0.93


def test_what_places_of_several_sites_leave_out_is_said(of_several_heights):
    plots = of_several_heights.drop("altitude_m")
    notes = jink.track(plots, site=SITES, details=True).summary["notes"]
    assert any("ranges without heights are taken as ranges along the ground" in note for note in notes)
    assert not any("range rate" in note for note in notes)
    notes = jink.track(plots.with_columns(range_rate=pl.lit(3.0)), site=SITES, details=True).summary["notes"]
    assert any("the range rate is not used" in note for note in notes)


def test_rows_in_order_are_in_order_of_several_sites_too(plots):
    """Rows were sorted by radar, so that those of the second radar came too late."""
    found = jink.track(plots, site=SITES, sort=False, details=True)
    assert not found.rejected.height
    assert found.summary["cleaning"]["unsorted"] == 0
