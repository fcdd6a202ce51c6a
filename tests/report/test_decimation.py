import numpy as np
import pytest

from jink.report.decimation import keep_rows


def test_short_series_are_kept_whole():
    assert keep_rows(np.zeros(5, int), np.arange(5.0), np.zeros((1, 5)), 10).tolist() == [0, 1, 2, 3, 4]


def test_straight_lines_go_first_and_corners_stay():
    time = np.arange(1000.0)
    saw = np.abs((time % 200) - 100) / 100
    keep = keep_rows(np.zeros(1000, int), time, saw[None], 60)
    assert keep.size <= 60
    assert set(range(100, 1000, 100)) <= set(keep.tolist())
    assert np.abs(np.interp(time, time[keep], saw[keep]) - saw).max() < 1e-6


def test_the_error_of_what_was_left_out_stays_small():
    rng = np.random.default_rng(0)
    time = np.cumsum(rng.uniform(0.5, 1.5, 20_000))
    series = np.stack([np.sin(time / 150), np.cos(time / 90) ** 3, (time % 700 < 30) * 1.0])
    keep = keep_rows(np.zeros(20_000, int), time, series, 4_000)
    assert keep.size <= 4_000
    drawn = np.stack([np.interp(time, time[keep], s[keep]) for s in series])
    assert np.abs(drawn - series).max() < 0.02


def test_a_lone_spike_and_marked_rows_survive():
    time = np.arange(5000.0)
    values = np.sin(time / 300)
    values[1234] += 1.0
    bonus = np.zeros(5000)
    bonus[777] = 0.5
    keep = keep_rows(np.zeros(5000, int), time, values[None], 200, bonus)
    assert {777, 1234} <= set(keep.tolist())


def test_every_track_keeps_its_ends_and_gaps_keep_their_edges():
    group = np.repeat(np.arange(50), 100)
    time = np.tile(np.arange(100.0), 50)
    values = np.ones(5000)
    values[250:260] = np.nan
    keep = set(keep_rows(group, time, values[None], 400).tolist())
    for k in range(50):
        assert {100 * k, 100 * k + 99} <= keep
    assert {249, 250, 259, 260} <= keep


@pytest.mark.parametrize("rows", [1, 2, 3])
def test_tiny_tracks_are_never_emptied(rows):
    group = np.repeat(np.arange(100), rows)
    keep = keep_rows(group, np.tile(np.arange(float(rows)), 100), np.zeros((1, 100 * rows)), 10)
    assert np.unique(group[keep]).size == 100


def test_all_rows_missing_or_at_one_time():
    time = np.zeros(100)
    keep = keep_rows(np.zeros(100, int), time, np.full((2, 100), np.nan), 10)
    assert keep.size <= 10 and keep[0] == 0 and keep[-1] == 99
