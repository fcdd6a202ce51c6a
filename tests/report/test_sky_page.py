"""Pages of plots without identity: layers, clutter map, and tracks of several trackers."""

import json
import re

import numpy as np
import polars as pl
import pytest

import jink
from jink.compare.sky_race import race_on_sky
from jink.report.arrays import ArrayBlock
from jink.report.rows import read_rows
from jink.report.sky_layers import add_sky, clutter_map
from jink.report.sky_page import sky_page_text, write_sky_page
from jink.scenarios.skies import sky_called


@pytest.fixture(scope="module")
def found():
    run = sky_called("sky-parallel-200").run(0, 4)
    plots = pl.concat([pl.DataFrame({"time": s.time, "x": s.z[:, 0], "y": s.z[:, 1]}) for s in run.scans])
    return jink.track(plots, anonymous={"detection": 0.9}, sensor_sd=50, details=True), plots


@pytest.fixture(scope="module")
def race():
    return race_on_sky("sky-parallel", ["imm"], ["marginal", "pda"], 1, 5, example=True)


def meta_of(text):
    match = re.search(r'<script type="application/json" id="meta">(.*?)</script>', text, re.S)
    assert match
    return json.loads(match[1])


def test_every_plot_is_a_tracks_or_lone(found):
    tracked, plots = found
    sky = tracked.sky
    assert sky.plots.height == plots.height and sky.scans == 80
    assert sky.plots["used"].sum() == tracked.tracks["row"].is_not_null().sum()
    assert sky.plots.filter("used")["lone"].mean() < 0.1 < 0.9 < sky.plots.filter(~pl.col("used"))["lone"].mean()
    assert set(sky.tentative.columns) >= {"track", "time", "x", "y", "existence"}


def test_tracks_that_were_never_confirmed_are_tentative():
    rng = np.random.default_rng(3)
    filter = jink.Kalman(jink.ConstantVelocity(acceleration_psd=1.0), jink.Position(sd=50.0))
    radar = jink.Radar(detection=0.9, clutter_per_scan=20, area=(0, 7e4, 0, 3e4))
    tracker = jink.Tracker(filter, radar, new_per_hour=100, report=0.02)
    from jink.association.batch import Scans, track_scans

    z = rng.uniform((0, 0), (7e4, 3e4), (200, 2))
    young = track_scans(tracker, Scans(4.0 * np.arange(10), np.arange(0, 201, 20), z)).tentative
    assert len(young.id) > 0 and young.position.shape == (len(young.id), 2)
    assert (np.diff(young.id) >= 0).all() and (young.existence >= 0.02).all() and (young.existence < 0.8).all()


def test_the_clutter_map_is_a_density():
    # 4 plots per km² and scan over 10 × 6 km, seen in 5 scans
    rng = np.random.default_rng(1)
    places = rng.uniform((0, 0), (10e3, 6e3), (4 * 60 * 5, 2))
    density, sides, corner = clutter_map(*places.T, np.ones(len(places)), 5)
    rows, columns = density.shape
    assert (columns * sides[0], rows * sides[1]) == pytest.approx(np.ptp(places, axis=0))
    assert corner == pytest.approx(places.min(axis=0))
    # 200 cells of 6 plots: their mean is 4 within 1 %, and smoothing leaves a spread of 4 × √(1/6) × 3/8
    assert 1e6 * density.mean() == pytest.approx(4.0, rel=0.02)
    assert 1e6 * density.std() == pytest.approx(4.0 * np.sqrt(1 / 6) * 3 / 8, rel=0.35)


def test_the_clutter_map_shows_where_false_plots_are_dense():
    rng = np.random.default_rng(2)
    places = np.vstack([rng.uniform((0, 0), (1e4, 1e4), (300, 2)), rng.uniform((7e3, 7e3), (1e4, 1e4), (300, 2))])
    density, sides, _ = clutter_map(*places.T, np.ones(600), 1)
    row, column = np.unravel_index(density.argmax(), density.shape)
    assert (column + 0.5) * sides[0] > 7e3 and (row + 0.5) * sides[1] > 7e3
    alone, _, _ = clutter_map(np.zeros(3), np.zeros(3), np.ones(3), 1)
    assert alone.shape == (1, 1) and np.isfinite(alone).all()


def test_plots_on_the_map_lie_where_the_tracks_do():
    degree = 111_195.0
    run = sky_called("sky-parallel-200").run(0, 4)
    plots = pl.concat(
        [
            pl.DataFrame({"time": s.time, "latitude": s.z[:, 1] / degree, "longitude": 10 + s.z[:, 0] / degree})
            for s in run.scans
        ]
    )
    tracked = jink.track(plots, anonymous={"detection": 0.9}, sensor_sd=50, details=True)
    rows = read_rows(tracked.tracks)
    from jink.report.plan import plan_coordinates

    east, north, frame = plan_coordinates(rows)
    block = ArrayBlock()
    told = add_sky(block, tracked.sky, frame, rows)
    assert told["plots"] == plots.height and frame is not None
    # the plots are spread over the area around the middle of the tracks, in the plan's metres
    assert told["map"]["corner"][0] < east.min() and told["map"]["corner"][1] < north.min()
    assert told["map"]["columns"] * told["map"]["sides"][0] == pytest.approx(70e3, rel=0.02)


def test_the_page_of_a_race_has_every_trackers_tracks_the_truth_and_the_figures(race):
    text = sky_page_text(race, "jink compare sky-parallel")
    meta = meta_of(text)
    assert meta["sky"]["series"] == ["marginal", "pda"] and meta["sky"]["truth"] == 2
    assert all(name.startswith(("marginal ", "pda ")) for name in meta["targets"]["name"])
    for piece in ("GOSPA", "MOTA", "cut-off 300 m", "jink compare sky-parallel", "tracks of 2 trackers"):
        assert piece in text
    with pytest.raises(ValueError, match="has no example"):
        sky_page_text(race_on_sky("sky-crossing", ["imm"], ["marginal"], 1, 5))


def test_layers_and_trackers_in_a_browser(race, open_page, tmp_path):
    write_sky_page(race, tmp_path / "sky.html")
    opened = open_page(tmp_path / "sky.html")
    page = opened.page
    assert page.locator("#layers label").count() >= 3
    marginal = page.locator("#list tbody tr").count()
    assert opened.chosen().startswith("marginal ") and page.locator(".head", has_text="Existence").count() == 1

    def picture():
        page.wait_for_timeout(150)
        return page.evaluate("document.querySelector('#plan canvas').toDataURL()")

    before = picture()
    for layer in ("plots", "clutter", "truth"):
        page.locator(f"#layer-{layer}").uncheck()
        after = picture()
        assert after != before, layer
        before = after
    page.select_option("#series", label="pda")
    assert opened.chosen().startswith("pda ") and page.locator("#list tbody tr").count() != marginal
    assert picture() != before
    assert opened.complaints == []


def test_a_page_of_named_tracks_has_no_layers(open_page, tracks, tmp_path):
    from jink.report import write_report

    write_report(tracks(2, 30), tmp_path / "page.html", summary={})
    page = open_page(tmp_path / "page.html").page
    assert not page.locator("#layers").is_visible() and not page.locator("#series").is_visible()
