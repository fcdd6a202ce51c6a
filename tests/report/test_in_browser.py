"""The page opened in headless Chromium. A machine without a browser or playwright skips this, saying so."""

from collections.abc import Callable
from pathlib import Path

import polars as pl
import pytest
from browser import Opened

from jink.report import write_report


@pytest.fixture
def look(open_page, tmp_path: Path) -> Callable[..., Opened]:
    """look(tracks, summary, **options): write the page, open it, wait until it is drawn."""

    def write_and_open(
        tracks: pl.DataFrame, summary=None, *, size=(1280, 800), anchor="", dark=False, **options
    ) -> Opened:
        path = tmp_path / "page.html"
        write_report(tracks, path, summary=summary or {}, **options)
        return open_page(path, size=size, anchor=anchor, dark=dark)

    return write_and_open


def click_track(opened: Opened, target: str) -> None:
    """Click in the plan view on the middle row of `target`, found through the page's own projection."""
    opened.page.locator("#plan").scroll_into_view_if_needed()
    x, y = opened.page.evaluate("(name) => window.jinkPage.whereIs(name)", target)
    box = opened.page.locator("#plan").bounding_box()
    assert box is not None and 0 < x < box["width"] and 0 < y < box["height"]
    opened.page.mouse.click(box["x"] + x, box["y"] + y)
    opened.page.wait_for_timeout(50)


def test_a_target_chosen_by_a_click_in_the_table(look, tracks, summary):
    frame = tracks(6, 300)
    opened = look(frame, summary, title="Six flights")
    assert opened.page.locator("#list tbody tr").count() == 6
    first = opened.chosen()
    row = opened.page.locator("#list tbody tr:not([aria-current])").first
    name = row.locator("button").inner_text()
    row.click()
    assert opened.chosen() == name != first
    assert opened.page.locator("#list tr[aria-current=true] button").inner_text() == name
    assert opened.page.url.endswith(f"#target={name}")
    assert opened.complaints == []
    assert [u for u in opened.requests if not u.startswith("file:///")] == [] and len(opened.requests) == 1


def test_a_target_chosen_by_a_click_on_its_track(look, tracks):
    frame = tracks(5, 300)
    opened = look(frame)
    for name in frame["target"].unique().sort().to_list()[:3]:
        opened.page.click("#plan-all")
        opened.page.wait_for_timeout(50)
        click_track(opened, name)
        assert opened.chosen() == name
    assert opened.complaints == []


def test_charts_show_values_at_the_cursor_and_zoom_in_time(look, tracks):
    opened = look(tracks(3, 400))
    page = opened.page
    box = page.locator("#charts").bounding_box()
    assert box
    assert opened.value("speed") == ""
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 80)
    assert "±" in opened.value("speed") and opened.value("speed").endswith("m/s")
    assert opened.value("modes").count(" · ") == 2
    assert page.locator("#time-all").is_disabled()
    page.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + 80)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 80, steps=3)
    page.mouse.up()
    assert page.locator("#time-all").is_enabled()
    low, high, start, end = page.evaluate("() => window.jinkPage.timeWindow()")
    assert start < low < high < end and (high - low) < 0.3 * (end - start)
    page.click("#time-all")
    assert page.evaluate("() => window.jinkPage.timeWindow()")[:2] == [start, end]
    assert opened.complaints == []


def test_keyboard_alone(look, tracks):
    opened = look(tracks(4, 200))
    page = opened.page
    page.locator("#list tbody tr button").first.focus()
    page.keyboard.press("ArrowDown")
    assert opened.chosen() == page.locator("#list tbody tr button").nth(1).inner_text()
    page.locator("#charts canvas.over").focus()
    page.keyboard.press("ArrowRight")
    assert "m/s" in opened.value("speed")
    page.keyboard.press("+")
    assert page.locator("#time-all").is_enabled()
    page.keyboard.press("0")
    assert page.locator("#time-all").is_disabled()
    before = page.evaluate("() => window.jinkPage.view()")
    page.locator("#plan canvas.over").focus()
    page.keyboard.press("+")
    assert page.evaluate("() => window.jinkPage.view()")["k"] > before["k"]
    assert opened.complaints == []


def test_table_sorts_and_finds(look, tracks):
    opened = look(tracks(8, 200))
    page = opened.page
    heads = page.locator("#list th")
    assert heads.nth(0).get_attribute("aria-sort") == "ascending"
    heads.nth(4).locator("button").click()
    speeds = [float(s) for s in page.locator("#list tbody tr td:nth-child(5)").all_inner_texts()]
    assert speeds == sorted(speeds, reverse=True) and heads.nth(4).get_attribute("aria-sort") == "descending"
    heads.nth(4).locator("button").click()
    assert [float(s) for s in page.locator("#list tbody tr td:nth-child(5)").all_inner_texts()] == sorted(speeds)
    name = page.locator("#list tbody tr button").nth(2).inner_text()
    page.fill("#find", name.upper())
    assert page.locator("#list tbody tr button").all_inner_texts() == [name]
    assert opened.complaints == []


def test_units_and_colours(look, tracks):
    opened = look(tracks(2, 100))
    page = opened.page
    metric = float(page.locator("#list tbody tr td:nth-child(5)").first.inner_text())
    page.select_option("#units", "nautical")
    assert float(page.locator("#list tbody tr td:nth-child(5)").first.inner_text()) == pytest.approx(
        metric * 1.9438, rel=0.01
    )
    page.select_option("#colour", "speed")
    assert page.locator("#legend-high").inner_text().endswith("kt")
    assert opened.complaints == []


def test_the_ends_of_the_colours_are_what_a_hundredth_of_the_rows_lie_beyond(look, tracks):
    stands = pl.int_range(pl.len()) % 40 == 0
    frame = tracks(2, 400).with_columns(speed=pl.when(stands).then(1e-11).otherwise("speed"))
    page = look(frame).page
    page.select_option("#colour", "speed")
    high = frame["speed"].quantile(0.99)
    assert page.locator("#legend-low").inner_text() == "≤ 0 m/s"
    assert page.locator("#legend-high").inner_text().startswith("≥ ")
    assert float(page.locator("#legend-high").inner_text().split()[1]) == pytest.approx(high, rel=0.01)


def test_a_name_that_looks_like_html(look, tracks):
    nasty = '</script><b>"&amp;\u2028'
    frame = tracks(2, 60)
    names = pl.when(pl.col("target") == frame["target"][0]).then(pl.lit(nasty)).otherwise(pl.lit("plain"))
    opened = look(frame.with_columns(target=names), {nasty: {nasty: nasty}}, title=nasty)
    page = opened.page
    page.locator("#list tbody tr", has_text="plain").click()
    page.locator("#list tbody tr", has_text="script").click()
    assert page.evaluate("() => document.documentElement.dataset.chosen") == nasty
    assert page.locator("#list b, .cards b, h1 b").count() == 0
    assert opened.complaints == []


def test_opened_at_a_target(look, tracks):
    frame = tracks(4, 60).with_columns(target=pl.lit("häß 1/") + pl.col("target"))
    name = frame["target"][-1]
    opened = look(frame, anchor=f"#target={name.replace('ä', '%C3%A4').replace('ß', '%C3%9F').replace(' ', '%20')}")
    assert opened.chosen() == name
    assert opened.complaints == []


CASES = {
    "metres only, no altitude, no clock": lambda t: t(3, 100, geographic=False, altitude=False, clock=False),
    "one target": lambda t: t(1, 100),
    "one row": lambda t: t(1, 1),
    "many single rows": lambda t: t(40, 1),
    "no rows": lambda t: t(1, 3).clear(),
    "date line": lambda t: t(3, 100, centre=(0.0, 179.9)),
    "far north": lambda t: t(3, 100, centre=(89.0, 10.0)),
    "all missing": lambda t: (f := t(2, 50)).with_columns(
        pl.lit(None, dtype=pl.Float64).alias(c) for c in f.columns if f[c].dtype.is_float()
    ),
    "holes": lambda t: (f := t(2, 200)).with_columns(
        pl.when(pl.int_range(pl.len()) % 17 < 5).then(None).otherwise(pl.col(c)).alias(c)
        for c in f.columns
        if f[c].dtype.is_float()
    ),
    "bare columns": lambda t: t(2, 50).select("target", "time", "latitude", "longitude"),
    "one instant": lambda t: t(1, 20).with_columns(time=pl.lit(5.0)),
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("size", [(1280, 800), (390, 844)])
def test_odd_tables_open_without_complaint(look, tracks, case, size):
    opened = look(CASES[case](tracks), size=size, dark=size[0] < 500)
    page = opened.page
    if page.locator("#list tbody tr").count():
        page.locator("#list tbody tr").last.click()
        page.click("#time-in")
        page.click("#plan-all")
        page.wait_for_timeout(50)
        assert opened.chosen()
        assert all(abs(v) < 1e12 for v in page.evaluate("() => Object.values(window.jinkPage.view())"))
    assert page.evaluate("() => document.documentElement.scrollWidth <= window.innerWidth")
    assert opened.complaints == []


def test_two_hundred_flights_open(look, tracks, summary):
    opened = look(tracks(200, 1500), summary, size=(1920, 1080))
    page = opened.page
    page.evaluate("window.jinkPage.redraw()")
    page.locator("#list tbody tr").nth(20).click()
    assert opened.chosen() == page.locator("#list tbody tr").nth(20).locator("button").inner_text()
    assert opened.complaints == []


def test_coasts_and_borders_lie_behind_the_tracks(look, tracks):
    opened = look(tracks(3, 100, centre=(51.0, 1.4)))  # the strait of Dover
    lines = opened.page.evaluate("() => window.jinkPage.world()")
    assert lines > 0
    assert opened.complaints == []


def test_all_targets_at_one_moment(look, tracks):
    opened = look(tracks(5, 300))
    page = opened.page
    assert page.locator("#replay-text").inner_text() == "all times" and page.locator("#replay-off").is_disabled()
    page.locator("#replay-slider").fill("5000")
    first = page.evaluate("() => window.jinkPage.moment()")
    page.click("#replay-play")
    page.wait_for_timeout(300)
    page.click("#replay-play")
    assert page.evaluate("() => window.jinkPage.moment()") > first
    assert page.locator("#replay-play").inner_text() == "Play"
    page.click("#replay-off")
    assert page.evaluate("() => window.jinkPage.moment()") is None
    assert opened.complaints == []


def test_a_distance_is_measured(look, tracks):
    opened = look(tracks(2, 100, centre=(0.0, 10.0)))
    page = opened.page
    page.click("#measure")
    box = page.locator("#plan").bounding_box()
    view = page.evaluate("() => window.jinkPage.view()")
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 100, y, steps=4)
    page.mouse.up()
    length, direction = page.evaluate("() => window.jinkPage.measured()")
    assert length == pytest.approx(100 / (view["k"] * view["aspect"]), rel=0.01)  # the sphere is flat over so little
    assert direction == pytest.approx(90.0, abs=0.5)
    after = page.evaluate("() => window.jinkPage.view()")
    assert after == view  # the plan did not move along
    assert opened.complaints == []


def test_the_address_leads_back_to_time_and_units(look, tracks):
    frame = tracks(3, 400)
    opened = look(frame)
    page = opened.page
    page.locator("#list tbody tr").nth(1).click()
    page.click("#time-in")
    page.select_option("#units", "nautical")
    anchor = page.url[page.url.index("#") :]
    assert "from=" in anchor and anchor.endswith("units=nautical")
    window = page.evaluate("() => window.jinkPage.timeWindow()")
    again = look(frame, anchor=anchor)
    assert again.chosen() == opened.chosen()
    assert again.page.evaluate("() => window.jinkPage.timeWindow()") == pytest.approx(window, abs=0.01)
    assert again.page.locator("#units").input_value() == "nautical"
    assert again.complaints == []


def test_rows_of_a_target_as_csv(look, tracks):
    frame = tracks(2, 50).with_columns(target=pl.lit("=1+1,") + pl.col("target"))
    opened = look(frame)
    name = frame["target"][0]
    text = opened.page.evaluate("(name) => window.jinkPage.csv(name)", name)
    rows = pl.read_csv(text.encode())
    mine = frame.filter(pl.col("target") == name)
    assert rows.height == mine.height and rows["target"].unique().to_list() == ["'" + name]
    assert (rows["latitude"] - mine["latitude"]).abs().max() < 1e-6
    assert (rows["speed"] - mine["speed"]).abs().max() < 0.01
    with opened.page.expect_download() as waiting:
        opened.page.click("#rows-csv")
    assert waiting.value.suggested_filename.endswith(".csv")
    with opened.page.expect_download() as waiting:
        opened.page.click("#plan-png")
    assert waiting.value.suggested_filename == "plan.png"
    assert opened.complaints == []


def test_a_name_that_is_not_there(look, tracks):
    opened = look(tracks(3, 50))
    opened.page.fill("#find", "nobody")
    assert "nobody" in opened.page.locator("#list td.nothing").inner_text()
    opened.page.locator("#list td.nothing").click()
    assert opened.complaints == []


def test_heights_are_seen_in_three_dimensions(look, tracks):
    opened = look(tracks(4, 200))
    page = opened.page
    assert page.locator(".space").is_hidden()
    page.click("#space")
    page.wait_for_timeout(80)
    picture = "() => document.querySelector('.space canvas').toDataURL()"
    before = page.evaluate(picture)
    assert page.locator("#measure").is_disabled() and page.locator("#space").get_attribute("aria-pressed") == "true"
    box = page.locator(".space").bounding_box()
    assert box and box["height"] > 200
    page.mouse.move(box["x"] + 100, box["y"] + 100)
    page.mouse.down()
    page.mouse.move(box["x"] + 180, box["y"] + 130, steps=3)
    page.mouse.up()
    page.wait_for_timeout(80)
    assert page.evaluate(picture) != before
    page.keyboard.press("Escape")
    assert page.locator(".space").is_hidden() and page.locator("#measure").is_enabled()
    assert opened.complaints == [] and len(opened.requests) == 1


def test_without_heights_there_is_no_third_dimension(look, tracks):
    opened = look(tracks(3, 100, altitude=False))
    assert opened.page.locator("#space").is_hidden()
    assert opened.complaints == []
