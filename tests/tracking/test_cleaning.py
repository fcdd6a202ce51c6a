"""Cleaning: every step does what it says, can be left out, and no row is lost on the way."""

import numpy as np
import polars as pl
import pytest
from hypothesis import given
from hypothesis import strategies as st
from straight import Journey

import jink
from jink.io.rejected import together
from jink.tracking.cleaning import Cleaned, Cleaning, clean


def _rows(time, x, target=None, source=None, speed=None, y=None) -> pl.DataFrame:
    count = len(time)
    return pl.DataFrame(
        {
            "file": ["f"] * count,
            "row": pl.Series(range(count), dtype=pl.UInt32),
            "target": target or ["a"] * count,
            "source": source or ["s"] * count,
            "time": [float(t) for t in time],
            "x": [np.nan if v is None else float(v) for v in x],
            "y": [0.0 if v is not None else np.nan for v in x] if y is None else y,
            "speed": [np.nan if s is None else float(s) for s in speed or [None] * count],
        },
        strict=False,
    )


def _clean(rows: pl.DataFrame, **options) -> Cleaned:
    return clean(rows.clone(), "cartesian", Cleaning(**({"gap": 60.0, "min_points": 1} | options)))


def _reasons(cleaned: Cleaned) -> dict[int, str]:
    rejected = together(cleaned.rejected)
    return dict(zip(rejected["row"], rejected["reason"], strict=True))


def test_rows_are_sorted_by_target_and_time_and_those_out_of_order_counted():
    cleaned = _clean(_rows([3, 1, 5, 2], [30, 10, 50, 20], target=["a", "b", "a", "a"]))
    assert cleaned.rows["row"].to_list() == [3, 0, 2, 1] and cleaned.counts["unsorted"] == 1


def test_without_sorting_rows_out_of_order_are_rejected():
    cleaned = _clean(_rows([1, 3, 2, 4], [10, 30, 20, 40]), sort=False)
    assert cleaned.rows["row"].to_list() == [0, 1, 3] and _reasons(cleaned) == {2: "time runs backwards"}


def test_of_two_rows_at_one_time_the_one_with_a_position_stays():
    rows = _rows([1, 2, 2, 2], [10, None, 20, 21])
    assert _reasons(_clean(rows)) == {1: "time occurs twice", 3: "time occurs twice"}
    assert _clean(rows, drop_duplicates=False).rows.height == 4


def test_two_sensors_may_see_a_target_at_the_same_time_but_not_send_the_same_plot():
    rows = _rows([1, 1, 2, 2], [10, 11, 20, 20], source=["p", "q", "p", "q"])
    assert _reasons(_clean(rows)) == {3: "time occurs twice"}


def test_repeated_positions_of_a_moving_target_become_misses():
    cleaned = _clean(_rows(range(8), [0, 200, 200, 200, 800, 1000, 1000, 1000]))
    assert cleaned.counts["stale_positions"] == 4  # two in the middle, two at the end
    assert cleaned.rows["measured"].to_list() == [True, True, False, False, True, True, False, False]
    assert np.isnan(cleaned.rows["x"].to_numpy()[[2, 3, 6, 7]]).all()
    assert _clean(_rows(range(8), [0, 200, 200, 200, 800, 1000, 1000, 1000]), drop_stale=False).rows["measured"].all()


def test_a_position_held_until_a_gap_is_stale_though_the_next_one_is_near():
    time = [0, 1, 2, 3, 4, 5, 6, 500, 501, 502, 503]
    held = _rows(time, [0, 80, 160, 240, 240, 240, 240, 300, 380, 460, 540], speed=[80] * 11)
    assert _clean(held).counts["stale_positions"] == 3  # 60 m in 494 s would be a target at rest
    assert _clean(held, gap=0.0).counts["stale_positions"] == 0
    parked = _rows(time, [0, 2, 4, 5, 5, 5, 5, 5, 6, 8, 10], speed=[2] * 11)
    assert _clean(parked).counts["stale_positions"] == 0


def test_a_target_at_rest_is_believed():
    parked = [0, 2, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5]
    assert _clean(_rows(range(13), parked)).counts["stale_positions"] == 0
    waiting = _rows(range(4), [0, 100, 100, 100], speed=[100, 100, 0, 0])
    assert _clean(waiting).counts["stale_positions"] == 0
    still_reported = _rows(range(6), [0, 100, 100, 100, 100, 100.5], speed=[100] * 6)
    assert _clean(still_reported).counts["stale_positions"] == 0


def test_gaps_begin_new_parts_and_rows_far_from_any_position_are_rejected():
    cleaned = _clean(_rows([0, 10, 50, 100, 500, 510, 600], [0, 10, None, None, 500, 510, None]))
    assert cleaned.rows["row"].to_list() == [0, 1, 2, 4, 5]
    assert cleaned.rows["part"].to_list() == [0, 0, 0, 1, 1] and cleaned.counts["gaps"] == 1
    assert set(_reasons(cleaned)) == {3, 6}
    assert _clean(_rows([0, 500], [0, 1]), gap=0.0).rows["part"].to_list() == [0, 0]


def test_rows_before_the_first_position_are_rejected():
    assert _reasons(_clean(_rows([0, 1, 2], [None, 10, 20]))) == {0: "before the target's first position"}


def test_short_parts_are_rejected_and_the_others_numbered_again():
    cleaned = _clean(_rows([0, 1, 2, 100, 200, 201, 202], [0, 1, 2, 100, 200, 201, 202]), min_points=3)
    assert cleaned.rows["part"].to_list() == [0, 0, 0, 1, 1, 1] and set(_reasons(cleaned)) == {3}
    assert cleaned.counts["short_parts"] == 1


ROW = st.tuples(
    st.sampled_from("abc"),
    st.integers(0, 400),
    st.one_of(st.none(), st.integers(0, 3)),
    st.sampled_from("pq"),
    st.one_of(st.none(), st.integers(0, 2)),
)


@given(
    st.lists(ROW, min_size=1, max_size=40),
    st.sampled_from([0.0, 5.0, 60.0]),
    st.integers(1, 4),
    st.booleans(),
    st.booleans(),
    st.booleans(),
)
def test_no_row_is_lost_or_doubled_whatever_is_switched(rows, gap, least, sort, duplicates, stale):
    target, time, x, source, speed = (list(column) for column in zip(*rows, strict=True))
    frame = _rows(time, x, target, source, speed)
    how = Cleaning(gap, least, sort, duplicates, stale)
    cleaned = clean(frame, "cartesian", how)
    found = cleaned.rows["row"].to_list() + together(cleaned.rejected)["row"].to_list()
    assert sorted(found) == list(range(len(rows)))
    kept = cleaned.rows
    steps = kept.select(pl.col("time").diff().over("target", "part"))["time"].drop_nulls()
    assert (steps >= 0).all()
    first = kept.group_by("target", "part", maintain_order=True).agg(
        pl.col("measured").first().alias("first"), pl.col("measured").sum().alias("points")
    )
    assert first["first"].all() and (first["points"] >= least).all()
    for _, parts in kept.group_by("target"):
        assert parts["part"].unique().sort().to_list() == list(range(parts["part"].n_unique()))


@pytest.mark.parametrize(("kind", "speed"), [("person", 1.4), ("vehicle", 20.0), ("vessel", 7.0), ("drone", 15.0)])
@pytest.mark.parametrize("smooth", [False, True])
def test_a_first_position_that_the_next_contradict_is_given_up(kind, speed, smooth):
    journey = Journey(count=30, speed=speed)
    north, east = np.array(journey.places).T
    north[0] += 0.025
    table = pl.DataFrame({"id": "a", "time": journey.times, "latitude": north, "longitude": east})
    tracks, rejected, summary = jink.track(table, kind=kind, smooth=smooth, details=True)
    assert rejected["row"].to_list() == [0] and "contradict" in rejected["reason"][0]
    assert tracks["speed"].max() == pytest.approx(speed, rel=0.02) and summary["cleaning"]["wrong_starts"] == 1
    assert jink.track(table, kind=kind, check_coordinates=False).height == 30


def test_whole_second_stamps_do_not_make_a_first_position_wrong():
    # 1.9 and then .1 s of way in the first two steps of one second
    time = np.arange(30.0)
    way = 250.0 * (time + np.r_[0.0, 0.9, np.zeros(28)])
    tracks = jink.track(pl.DataFrame({"id": "a", "time": time, "x": way, "y": 0.0 * way}), kind="aircraft")
    assert tracks.height == 30
