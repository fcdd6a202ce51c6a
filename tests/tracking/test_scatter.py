"""Noise from the data alone: right on known noise, whatever the motion, the steps and the outliers."""

import itertools

import numpy as np
import pytest

from jink._engine import native
from jink.io.errors import InputError
from jink.tracking.noise_level import parse_sensor_sd
from jink.tracking.scatter import component_sd, grouped_quantile, plane_scatter, rough_velocity, third_differences


def _flight(count=4000, *, sd=5.0, time_sd=0.0, seed=1, outliers=0.0):
    rng = np.random.default_rng(seed)
    time = np.cumsum(rng.uniform(0.5, 1.5, count))
    turning = (np.sin(time / 60.0) > 0.7) * 0.03
    course = np.cumsum(turning * np.diff(time, prepend=0.0))
    velocity = 200.0 * np.column_stack([np.sin(course), np.cos(course)])
    place = np.cumsum(velocity * np.diff(time, prepend=0.0)[:, None], axis=0)
    noisy = place + rng.normal(0, sd, (count, 2)) + velocity * rng.normal(0, time_sd, count)[:, None]
    noisy[rng.random(count) < outliers] += 50_000.0
    return time, noisy, np.arange(count) == 0


def _scatter(time, plane, new):
    velocity = rough_velocity(time, plane, new)
    return [float(v[0]) for v in plane_scatter(time, plane, velocity, new, np.zeros(time.size, int), 1)]


@pytest.mark.parametrize("sd", [0.5, 5.0, 100.0])
def test_the_position_noise_of_a_turning_target_is_found(sd):
    position, stamps = _scatter(*_flight(sd=sd))
    assert position == pytest.approx(sd, rel=0.1) and stamps == 0.0


def test_errors_of_time_stamps_are_told_from_errors_of_position():
    position, stamps = _scatter(*_flight(sd=2.0, time_sd=0.15))
    assert position == pytest.approx(2.0, rel=0.1) and stamps == pytest.approx(0.15, rel=0.1)


def test_turns_seen_by_a_slow_radar_are_not_taken_for_errors_of_its_clock():
    rng = np.random.default_rng(4)
    time = np.arange(2000) * 10.0
    course = np.cumsum(np.where(np.arange(2000) % 50 < 10, 0.5, 0.0))
    velocity = 200.0 * np.column_stack([np.sin(course), np.cos(course)])
    plane = np.cumsum(velocity * 10.0, axis=0) + rng.normal(0, 60.0, (2000, 2))
    position, stamps = _scatter(time, plane, np.arange(2000) == 0)
    assert position == pytest.approx(60.0, rel=0.35) and stamps == 0.0


def test_one_position_in_a_hundred_fifty_kilometres_away_changes_little():
    position, stamps = _scatter(*_flight(sd=5.0, outliers=0.01))
    assert position == pytest.approx(5.0, rel=0.2) and stamps < 0.1


def test_third_differences_ignore_parabolas_and_keep_the_variance_whatever_the_steps():
    rng = np.random.default_rng(3)
    time = np.cumsum(rng.uniform(0.1, 2.0, 5000))
    new = np.arange(5000) % 100 == 0
    parabola = 3.0 + 2.0 * time - 0.5 * time**2
    silent, _ = third_differences(time, parabola, new)
    assert np.abs(silent).max() < 1e-6 * np.abs(parabola).max()
    noise, index = third_differences(time, rng.normal(0, 7.0, 5000), new)
    assert noise.std() == pytest.approx(7.0, rel=0.05)
    assert not np.isin(index, np.flatnonzero(new)).any()


def test_the_step_of_quantisation_is_a_floor():
    time = np.arange(1000.0)
    level = np.where(time < 500, 3000.0, 3007.62)
    group = np.zeros(1000, int)
    new = time == 0
    assert np.isnan(component_sd(time[:10], level[:10], new[:10], group[:10], 1)[0])
    flat = np.full(1000, 10668.0) + 1e-12 * (time % 3)
    assert np.isnan(component_sd(time, flat, new, group, 1)[0])
    assert component_sd(time, level, new, group, 1)[0] == pytest.approx(7.62 / np.sqrt(12))
    stairs = np.round((time * 3.1) / 7.62) * 7.62
    assert component_sd(time, stairs, new, group, 1)[0] >= 7.62 / np.sqrt(12)


def test_a_receiver_that_holds_its_position_at_rest_does_not_look_exact():
    """An hour at rest in a trip of twenty minutes: the noise is that of the rows in motion."""
    rng = np.random.default_rng(7)
    speed = np.r_[np.full(600, 15.0), np.zeros(3600), np.full(600, 15.0)]
    time, place = np.arange(speed.size) * 1.0, np.cumsum(speed)
    plane = np.column_stack([place, 0.0 * place]) + rng.normal(0, 2.5, (speed.size, 2))
    plane[600:4200] = plane[600]
    new = time == 0
    assert _scatter(time, plane, new)[0] == pytest.approx(2.5, rel=0.15)
    held = plane[:, 0] - place
    held[600:4200] = held[600]
    assert component_sd(time, held, new, np.zeros(time.size, int), 1)[0] == pytest.approx(2.5, rel=0.15)


@pytest.mark.parametrize("climb", [0.0, 2.0, 150.0])
def test_steps_of_a_steady_climb_are_no_quantisation(climb):
    """A climb of 150 m from row to row had a noise of 40 m, whatever it was: its smallest step over the root of 12."""
    rng, time = np.random.default_rng(3), 10.0 * np.arange(400)
    new, group = time == 0.0, np.zeros(time.size, int)
    height = climb * np.arange(400) + rng.normal(0, 0.5, 400)
    assert component_sd(time, height, new, group, 1)[0] == pytest.approx(0.5, rel=0.15)
    steps = np.round(height / 7.62) * 7.62
    if climb:
        assert 7.62 / np.sqrt(12) * 0.99 < component_sd(time, steps, new, group, 1)[0] < 7.62


def test_groups_have_their_own_figure_or_none():
    one, other = _flight(sd=2.0, seed=1), _flight(sd=20.0, seed=2)
    few = _flight(count=10, seed=3)
    time, plane, new = (np.concatenate(parts) for parts in zip(one, other, few, strict=True))
    group = np.repeat([0, 1, 2], [4000, 4000, 10])
    position, _ = plane_scatter(time, plane, rough_velocity(time, plane, new), new, group, 3)
    assert position[0] == pytest.approx(2.0, rel=0.15) and position[1] == pytest.approx(20.0, rel=0.15)
    assert np.isnan(position[2])


def test_one_jump_does_not_move_the_rough_velocity():
    time, plane, new = _flight(sd=0.1)
    before = rough_velocity(time, plane, new)
    plane[100] += 1e6
    after = rough_velocity(time, plane, new)
    assert np.abs(after - before).max() < 60.0


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (None, {}),
        (25, {"position": 25.0}),
        ("25", {"position": 25.0}),
        ("position=25,altitude_ft=100,time=0.2", {"position": 25.0, "altitude": 30.48, "time": 0.2}),
        ({"range_km": 0.05, "azimuth_deg": 0.1}, {"range": 50.0, "azimuth": np.radians(0.1)}),
    ],
)
def test_sensor_sd_in_every_form(given, expected):
    assert parse_sensor_sd(given) == pytest.approx(expected)


@pytest.mark.parametrize("given", ["-3", "zero", "nan", "azimuth_furlong=1", {"speed": 1.0}, "position=0"])
def test_a_senseless_sensor_sd_is_refused(given):
    with pytest.raises(InputError, match="sensor-sd"):
        parse_sensor_sd(given)


@pytest.mark.parametrize("share", [0.01, 0.5, 0.9])
def test_the_quantile_of_a_group_is_the_nearest_of_its_known_values(share):
    rng = np.random.default_rng(4)
    value, group = rng.normal(size=(400, 2)), rng.integers(0, 7, 400)
    value[rng.random((400, 2)) < 0.2] = np.nan
    found = grouped_quantile(value, group, 8, share, least=3)
    for number in range(7):
        mine = value[group == number]
        wanted = np.quantile(mine[np.isfinite(mine)], share, method="nearest")
        assert abs(found[number] - wanted) <= np.ptp(mine[np.isfinite(mine)]) / 20  # a tie may go to either side
        assert found[number] in mine
    assert np.isnan(found[7])


@pytest.mark.parametrize("size", [2, 3, 6])
@pytest.mark.parametrize("bad", [0, 5, 8, 18])
def test_the_first_row_whose_noise_is_no_covariance_is_found_wherever_it_stands(size, bad):
    rng = np.random.default_rng(size)
    root = rng.normal(size=(19, size, size))
    noise = root @ root.transpose(0, 2, 1) + 0.1 * np.eye(size)
    noise = 0.5 * (noise + noise.transpose(0, 2, 1))
    assert native.first_indefinite(noise) == -1
    noise[bad:, 0, 1] = noise[bad:, 1, 0] = 1e3
    assert native.first_indefinite(noise) == bad


def test_rough_velocities_are_the_middle_of_three_slopes_of_their_own_track():
    time, plane, new = _flight(300, outliers=0.02)
    new[[70, 71, 200]] = True
    time[100] = time[99]  # a repeated time has no slope
    found = rough_velocity(time, plane, new, seconds=3.0, usual=1.0)
    begins = [*np.flatnonzero(new), 300]
    for first, end in itertools.pairwise(begins):
        for k in range(first, end):

            def slope(back, forward, k=k, first=first, end=end):
                a, b = max(k - back, first), min(k + forward, end - 1)
                return (plane[b] - plane[a]) / (time[b] - time[a]) if time[b] > time[a] else np.full(2, np.nan)

            wide = slope(6, 6)
            wanted = [np.where(np.isnan(each), wide, each) for each in (slope(3, 0), slope(0, 3))]
            np.testing.assert_allclose(found[k], np.nan_to_num(np.median([*wanted, wide], axis=0)), atol=1e-12)


def test_a_way_is_that_of_the_last_positions_and_unknown_where_noise_hides_it():
    angle = np.radians(np.r_[np.zeros(20), 3.0 * np.arange(20), np.zeros(10)])
    plane = np.cumsum(100.0 * np.column_stack([np.cos(angle), np.sin(angle)]), axis=0)
    new = np.isin(np.arange(50), [0, 40])
    way, doubt = native.ways(plane, new, np.array([3, 1]), np.array([2.0, 20.0]))
    # the first row of a track has none before it; in the second one a step is less than ten times the noise
    assert np.isnan(way[[0, *range(40, 50)]]).all()
    np.testing.assert_allclose(way[3:20], [[1.0, 0.0]] * 17)
    np.testing.assert_allclose(doubt[6:20], (2.0 / 300.0) ** 2)
    for k in range(23, 40):
        moved = plane[k] - plane[k - 3]
        np.testing.assert_allclose(way[k], moved / np.linalg.norm(moved))
        turned = (2.0 / np.linalg.norm(moved)) ** 2 + 0.5 * (1.0 - way[k] @ way[k - 3])
        np.testing.assert_allclose(doubt[k], turned)
