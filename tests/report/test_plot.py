"""jink.plot: the page of tracks or of a race as an object, the same as the command writes."""

from __future__ import annotations

import html
from dataclasses import replace

import numpy as np
import polars as pl
import pytest

import jink
from jink.compare.race import compare
from jink.report import write_report
from jink.report.race_page import write_race_report
from jink.scenarios import SCENARIOS


@pytest.fixture(scope="module")
def tracked():
    rng, t = np.random.default_rng(0), np.arange(50) * 2.0
    frame = pl.DataFrame({"target": ["a"] * 50, "time": t, "x": 90.0 * t + rng.normal(0, 9, 50), "y": 0.0 * t})
    return jink.track(frame.with_columns(y=rng.normal(0, 9, 50)), details=True)


def test_a_page_of_tracks_is_that_of_the_command(tracked, tmp_path):
    write_report(tracked.tracks, tmp_path / "want.html", summary=tracked.summary)
    page = jink.plot(tracked)
    assert page.save(tmp_path / "got.html") == tmp_path / "got.html"
    tracked.report(tmp_path / "report.html")
    want = (tmp_path / "want.html").read_text()
    assert page.html == want == (tmp_path / "got.html").read_text() == (tmp_path / "report.html").read_text()


def test_a_notebook_shows_the_whole_page_in_a_frame(tracked):
    shown = jink.plot(tracked.tracks, title="<Two> & more")._repr_html_()
    source = shown.removeprefix('<iframe srcdoc="').split('" width=')[0]
    assert '"' not in source and html.unescape(source) == jink.plot(tracked.tracks, title="<Two> & more").html
    assert "&lt;Two&gt; &amp; more" in html.unescape(source)
    assert repr(jink.plot(tracked)).startswith("Page(0.")


def test_tables_of_other_libraries(tracked):
    assert jink.plot(tracked.tracks.to_pandas()).html == jink.plot(tracked.tracks).html
    with pytest.raises(TypeError, match=r"plot: what: expected tracks .* or a race of jink.compare, got int"):
        jink.plot(3)
    with pytest.raises(ValueError, match="target"):
        jink.plot(pl.DataFrame({"time": [0.0]}))


def test_a_race_as_a_page_and_as_a_table(tmp_path):
    scenario = SCENARIOS["choi-2001-2"]
    race = compare(replace(scenario, schedule=replace(scenario.schedule, count=20)), ["imm-cv-ca"], runs=6)
    race.report(tmp_path / "race.html")
    write_race_report(race, tmp_path / "want.html")
    assert (tmp_path / "race.html").read_text() == (tmp_path / "want.html").read_text()
    table = race.to_frame()
    assert table.columns[:4] == ["filter", "metric", "value", "se"]
    told = {(row["filter"], row["metric"]): row for row in table.iter_rows(named=True)}
    for name in race.tallies:
        for metric, figure in race.figures(name).items():
            assert told[name, metric]["value"] == figure.value
    own = race.compare("kalman-cv", "imm", "position_rmse")
    assert told["kalman-cv", "position_rmse"]["difference_to_imm"] == own.difference
    assert told["kalman-cv", "position_rmse"]["verdict"] == own.verdict
