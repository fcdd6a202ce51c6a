"""The page of a race: what it says, and how it behaves in headless Chromium."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from jink.cli.compare import CompareRequest, command_line, run_compare
from jink.compare import simulated
from jink.compare.race import compare
from jink.compare.result import Race
from jink.io.errors import InputError
from jink.metrics import Figure
from jink.report.race_data import columns, half_width, interval_text
from jink.report.race_page import write_race_report
from jink.scenarios import SCENARIOS


def short(name: str, scans: int, **changes):
    scenario = SCENARIOS[name]
    return replace(scenario, schedule=replace(scenario.schedule, count=scans), **changes)


@pytest.fixture(scope="module")
def race() -> Race:
    return compare(short("random-turns", 80), ["imm-cv-ct", "singer"], runs=30, seed=1)


@pytest.fixture(scope="module")
def recorded() -> Race:
    return compare("examples/flights.parquet", ["imm-cv-ct"])


@pytest.fixture
def show(open_page, tmp_path):
    def write_and_open(race: Race, *, command: str = "jink compare it", **options):
        path = tmp_path / "race.html"
        write_race_report(race, path, command=command)
        return open_page(path, **options)

    return write_and_open


def clean(opened) -> bool:
    away = [url for url in opened.requests if not url.startswith("file:///")]
    return opened.complaints == [] and away == [] and len(opened.requests) == 1


def test_the_table_has_every_figure_with_its_interval(race, show):
    opened = show(race)
    rows = {
        row.locator("td").first.inner_text().split()[0]: row.locator("td").all_inner_texts()
        for row in opened.page.locator("#list tbody tr").all()
    }
    assert set(rows) == {*race.tallies, "PCRB"}
    heads = opened.page.locator("#list thead th").all_inner_texts()
    assert len(heads) == 1 + len(columns(race)) and heads[1].split()[0] == "position"
    figure = race.figure("imm", "position_rmse")
    value, half = rows["imm"][1].split(" ± ")
    assert float(value) == pytest.approx(figure.value, abs=0.06)
    assert float(half) == pytest.approx(half_width(figure, 30), rel=0.1)
    values = [float(text[1].split()[0]) for name, text in rows.items()]
    assert values == sorted(values)
    assert clean(opened)


def test_paired_differences_are_coloured_where_the_interval_says_so(race, show):
    opened = show(race)
    row = opened.page.locator(".paired tbody tr", has_text="singer")
    cells = row.locator("td")
    for k, other in enumerate(("raw", "kalman-cv", "kalman-ca", "imm")):
        verdict = race.compare("singer", other).verdict
        assert cells.nth(k).get_attribute("class") == verdict
        assert verdict == "undecided" or cells.nth(k).inner_text().endswith(verdict)
    assert clean(opened)


def test_filters_are_hidden_and_chosen(race, show):
    opened = show(race)
    page = opened.page
    chip = page.locator("#chips button", has_text="singer")
    assert chip.get_attribute("aria-pressed") == "true"
    before = page.evaluate("document.querySelector('#charts canvas').toDataURL()")
    chip.click()
    page.wait_for_timeout(100)
    assert chip.get_attribute("aria-pressed") == "false"
    assert page.evaluate("document.querySelector('#charts canvas').toDataURL()") != before
    assert page.evaluate("document.documentElement.dataset.chosen") == "imm"
    page.locator("#list tbody tr", has_text="singer").click()
    assert page.evaluate("document.documentElement.dataset.chosen") == "singer"
    assert chip.get_attribute("aria-pressed") == "true" and "one mode" in page.locator("#heads").inner_text()
    page.select_option("#chosen-filter", label="imm-cv-ct")
    assert "coordinated turn" in page.locator("#heads").inner_text()
    page.locator("#list tbody tr", has_text="PCRB").click()
    assert page.evaluate("document.documentElement.dataset.chosen") == "imm-cv-ct"
    assert clean(opened)


def test_readings_at_the_cursor_are_the_figures(race, show):
    opened = show(race)
    page = opened.page
    box = page.locator("#charts").bounding_box()
    assert box
    page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 50)
    page.wait_for_timeout(50)
    when = page.evaluate("window.jinkPage.state.chosen")
    assert page.locator("#chosen-filter").input_value() == str(when)
    text = opened.value("position")
    value, error = re.fullmatch(r"([\d.]+) ± ([\d.]+) m", text).groups()  # type: ignore[union-attr]
    over_time, se = race.tallies["imm"].over_time("position")
    k = int(np.argmin(np.abs(over_time - float(value))))
    assert over_time[k] == pytest.approx(float(value), abs=0.6)
    assert 2 * se[k] == pytest.approx(float(error), rel=0.1)
    assert "%" in opened.value("modes")
    page.mouse.down()
    page.mouse.move(box["x"] + 0.8 * box["width"], box["y"] + 50, steps=3)
    page.mouse.up()
    low, high, start, end = page.evaluate("window.jinkPage.timeWindow()")
    assert start < low < high < end
    page.click("#time-all")
    page.click("#plan-in")
    page.click("#plan-all")
    assert clean(opened)


def test_a_click_on_a_track_chooses_its_filter(race, show):
    opened = show(race)
    page = opened.page
    for name in ("raw", "kalman-cv", "kalman-ca", "imm", "clairvoyant", "imm-cv-ct"):
        page.locator("#chips button").get_by_text(name, exact=True).click()
    place = page.evaluate("window.jinkPage.whereIs('singer')")
    box = page.locator("#plan").bounding_box()
    page.mouse.click(box["x"] + place[0], box["y"] + place[1])
    assert page.evaluate("document.documentElement.dataset.chosen") == "singer"
    page.mouse.move(box["x"] + place[0] + 1, box["y"] + place[1])
    assert "from the truth" in page.locator("#tip").inner_text()
    assert clean(opened)


def test_recorded_tracks_show_predictions(recorded, show):
    opened = show(recorded)
    page = opened.page
    heads = page.locator("#heads").inner_text()
    assert "RMS prediction error" in heads and "ln p of the next row" in heads
    assert page.locator("#plan-title").inner_text().startswith("Tracks")
    assert page.locator(".legend .truth").count() == 0
    assert "prediction error" in page.locator("#paired-title").inner_text()
    box = page.locator("#charts").bounding_box()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 50)
    assert opened.value("error").endswith(" m")
    assert clean(opened)


CASES = {
    "one axis": lambda: compare(short("wang-2010-step", 70), runs=5),
    "one run": lambda: compare(short("random-turns", 30), runs=1),
    "a radar": lambda: compare(short("terminal-area", 30), runs=3),
    "three axes": lambda: compare(short("benchmark-1", 80), runs=3),
    "many misses": lambda: compare(short("random-turns", 40).seen_by(50.0, detection=0.2), runs=3),
    "one scan": lambda: compare(short("random-turns", 3), runs=3),
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("size", [(1280, 800), (390, 844)])
def test_odd_races_open_without_complaint(show, case, size):
    opened = show(CASES[case](), size=size, dark=size[0] < 500)
    page = opened.page
    assert page.locator("#plan-pane").is_visible() == (case != "one axis")
    page.locator("#list tbody tr").last.click()
    page.click("#time-in")
    assert page.evaluate("() => document.documentElement.scrollWidth <= window.innerWidth")
    assert clean(opened)


def test_names_that_look_like_html(race, show):
    nasty = '</script><b>"&amp;'
    bad = replace(race, scenario=nasty, words=nasty, seen=nasty, skipped={nasty: nasty})
    opened = show(bad, command=f"jink compare {nasty}")
    assert opened.page.locator("h1").inner_text().endswith(nasty.rpartition("/")[2])
    assert opened.page.locator("main b b, .card b, h1 b, .lede b").count() == 0
    assert opened.page.locator("code").inner_text() == f"jink compare {nasty}"
    assert clean(opened)


def test_it_says_that_it_was_interrupted(race, show):
    opened = show(replace(race, asked=1000))
    assert opened.page.locator("#partial").inner_text() == "Interrupted after 30 of 1,000 runs."


def test_intervals_are_written_to_the_digits_that_they_leave():
    assert interval_text("position_rmse", Figure(374.731, 0.914), 10_000) == "374.7 ± 1.8"
    assert interval_text("nees_inside", Figure(0.9512, 0.001), 10_000) == "95.12 ± 0.20 %"
    assert interval_text("log_score", Figure(-24.918, 0.01), 10_000) == "−24.918 ± 0.020"
    assert interval_text("onset_settling", Figure(float("inf"), float("nan")), 10) == "never"
    assert interval_text("lost", Figure(float("nan"), 0.0), 10) == "–"
    assert interval_text("position_rmse", Figure(3.14159, float("nan")), 1) == "3.142"
    assert half_width(Figure(1.0, 1.0), 5) == pytest.approx(2.776, rel=0.01)


def ask(**changes) -> CompareRequest:
    return CompareRequest(**{"scenario": "choi-2001-1", "filters": "singer", "runs": 6, "seed": 3, **changes})


def test_the_command_on_the_page_does_it_again(tmp_path):
    """The same figures, from the command as it is written there."""
    first, second = tmp_path / "a.json", tmp_path / "b.json"
    page = tmp_path / "page.html"
    request = ask(sensor="2", detection=0.9, json=str(first), report=str(page), kind="fighter")
    assert run_compare(replace(request, quiet=True)) == 0
    command = command_line(request)
    assert command.replace("&", "&amp;") in page.read_text(encoding="utf-8")
    words = command.split()[1:]
    subprocess.run([sys.executable, "-m", "jink", *words, "--json", str(second), "-q"], check=True)
    a, b = (json.loads(path.read_text()) for path in (first, second))
    for name, figures in a["filters"].items():
        for metric, figure in figures.items():
            assert metric == "us_per_update" or b["filters"][name][metric] == figure


def test_both_outputs_or_none(tmp_path, monkeypatch, capsys):
    page, out = tmp_path / "page.html", tmp_path / "o.json"
    page.write_text("old")

    def broken(*args, **kwargs):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("jink.report.race_page.write_page", broken)
    assert run_compare(ask(report=str(page), json=str(out))) == 1
    assert "No space left" in capsys.readouterr().err
    assert page.read_text() == "old" and [p.name for p in tmp_path.iterdir()] == ["page.html"]


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"report": "-"}, "--report -: expected a file"),
        ({"report": "/nowhere/p.html"}, "--report /nowhere/p.html: expected a file in a folder that exists"),
        ({"report": "x.html", "json": "x.html"}, "expected two names"),
    ],
)
def test_wrong_outputs(changes, said, capsys):
    assert run_compare(ask(**changes)) == 2
    assert said in capsys.readouterr().err


def test_a_race_that_is_interrupted_writes_what_is_finished(tmp_path, monkeypatch):
    monkeypatch.setattr(simulated, "CHUNK_ROWS", 60)
    seen = []

    def count(tally, *args):
        seen.append(1)
        if len(seen) > 40:
            raise KeyboardInterrupt

    monkeypatch.setattr(simulated.manoeuvring, "count", count)
    page, out = tmp_path / "page.html", tmp_path / "o.json"
    assert run_compare(ask(runs=1000, report=str(page), json=str(out), quiet=True)) == 130
    body = json.loads(out.read_text())
    assert body["partial"] and 0 < body["runs"] < 1000 == body["runs_asked"]
    assert f"Interrupted after {body['runs']} of 1,000 runs." in page.read_text(encoding="utf-8")
    assert "hidden" not in page.read_text(encoding="utf-8").split('id="partial"')[1].split(">")[0]


def test_in_python_it_needs_a_path_that_can_be_written(race, tmp_path):
    with pytest.raises(OSError):
        write_race_report(race, tmp_path / "none" / "page.html")
    with pytest.raises(InputError, match="unknown filter"):
        compare("lee-2003", ["nonesuch"])
