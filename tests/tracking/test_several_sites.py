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
