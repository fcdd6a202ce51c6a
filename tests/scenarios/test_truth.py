"""Truth is exact: velocity is the derivative of position, and acceleration that of velocity."""

import numpy as np
import pytest

from jink.metrics.draws import Draws
from jink.scenarios import SCENARIOS

STEP = 2.0**-6
STENCIL = {-2: 1 / 12, -1: -8 / 12, 1: 8 / 12, 2: -1 / 12}  # fourth-order central difference


def smooth_times(truth, duration: float, count: int = 400) -> np.ndarray:
    """(B, n) times whose neighbourhood has no jump in acceleration or its rate; NaN where one is near."""
    time = np.random.default_rng(1).uniform(4 * STEP, duration, (truth.runs, count))
    for row, breaks in zip(time, np.broadcast_to(truth.breaks(), (truth.runs, truth.breaks().shape[1])), strict=True):
        distance = np.abs(row[:, None] - breaks[None, :]).min(axis=1)
        row[distance <= 2 * STEP] = row[distance > 2 * STEP][0]
    return time


@pytest.mark.parametrize("name", SCENARIOS)
def test_velocity_and_acceleration_are_derivatives(name):
    scenario = SCENARIOS[name]
    truth = scenario.truth(Draws(3, range(4)))
    time = smooth_times(truth, scenario.schedule.end)
    middle = truth.at(time)
    around = {k: truth.at(time + k * STEP) for k in STENCIL}
    for lower, upper in ((0, 1), (1, 2)):
        derivative = sum(weight * around[k][lower] for k, weight in STENCIL.items()) / STEP
        scale = np.abs(middle[upper]).max() + 1.0
        np.testing.assert_allclose(derivative, middle[upper], rtol=0, atol=1e-6 * scale)


@pytest.mark.parametrize("name", SCENARIOS)
def test_nothing_jumps_that_must_not(name):
    """Position and velocity are continuous at the joints (choi-2001-3's velocity jumps by its definition)."""
    truth = SCENARIOS[name].truth(Draws(3, range(4)))
    joints = np.broadcast_to(truth.breaks(), (truth.runs, truth.breaks().shape[1]))
    before, after = truth.at(joints - 1e-9), truth.at(joints + 1e-9)
    np.testing.assert_allclose(before.position, after.position, rtol=0, atol=1e-4)
    if name != "choi-2001-3":
        np.testing.assert_allclose(before.velocity, after.velocity, rtol=0, atol=1e-5)


@pytest.mark.parametrize("name", SCENARIOS)
def test_a_run_is_the_same_in_any_company(name):
    scenario = SCENARIOS[name]
    together = scenario.simulate(7, seed=5)
    for piece in scenario.chunks(7, seed=5, size=3):
        for whole, part in [(together.z, piece.z), *zip(together.truth, piece.truth, strict=True)]:
            np.testing.assert_array_equal(whole[piece.runs], part)
    alone = scenario.simulate([6, 2], seed=5)
    np.testing.assert_array_equal(alone.z, together.z[[6, 2]])
    assert not np.array_equal(scenario.simulate(7, seed=6).z, together.z)


def test_runs_of_random_families_differ_and_shared_truths_do_not():
    position = SCENARIOS["random-turns"].simulate(5, 1).truth.position
    assert len(np.unique(position[:, -1, 0])) == 5
    assert np.ptp(SCENARIOS["choi-2001-4"].simulate(5, 1).truth.position, axis=0).max() == 0


@pytest.mark.parametrize(
    ("runs", "seed", "said"),
    [
        (0, 1, "runs: expected"),
        ([], 1, "runs: expected"),
        ([-1], 1, "runs: expected"),
        (3, -1, "seed: expected"),
        (3, 1.5, "seed: expected"),
    ],
)
def test_wrong_numbers_are_refused(runs, seed, said):
    with pytest.raises(ValueError, match=said):
        SCENARIOS["lee-2003"].simulate(runs, seed)
