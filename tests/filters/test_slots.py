"""Live targets that come and go in one batch have the estimates of live targets by themselves, bit by bit."""

from __future__ import annotations

import numpy as np
import pytest

import jink
from jink.catalogue.purpose import Purpose
from jink.catalogue.registry import FILTERS

SENSOR = jink.Position(sd=20.0, axes=2)
NAMES = ["kalman-cv", "imm", "imm-cv-ct", "aimm3", "vsmm-ad", "variable-dimension", "input-estimation", "gpb2", "nn-kf"]


def made(name: str):
    return FILTERS[name](Purpose(sensor=SENSOR, kind="aircraft")).filter


def rows(targets: int, count: int, seed: int = 0):
    """Target, time and measurement of rows of several targets, in no order but that of time within each."""
    rng = np.random.default_rng(seed)
    which = rng.integers(0, targets, count)
    time = np.cumsum(rng.uniform(0.1, 1.0, count))
    places = np.column_stack([200.0 * time * np.cos(which), 200.0 * time * np.sin(which)]) + rng.normal(
        0, 20, (count, 2)
    )
    places[rng.random(count) < 0.1] = np.nan
    return which, time, places


@pytest.mark.parametrize("name", NAMES)
def test_a_slot_is_a_live_target(name):
    filter = made(name)
    which, time, z = rows(11, 600)
    slots, alone = filter.slots(), [filter.start(1) for _ in range(11)]
    mine = np.array([slots.take() for _ in range(11)])
    start = 0
    for size in (1, 1, 7, 40, 300, 251):
        some = slice(start, start + size)
        found = slots.update(mine[which[some]], time[some], z[some])
        for k in range(size):
            wanted = alone[which[start + k]].update(time[start + k], z[start + k : start + k + 1])
            for output in ("x", "P", "mode_probability", "nis", "nis_dof", "log_likelihood", "time", "status"):
                np.testing.assert_array_equal(found.results[output][k], wanted.results[output][0], err_msg=output)
        start += size
    assert start == 600


def test_a_slot_is_used_again_and_knows_nothing_of_its_last_target():
    filter = made("imm")
    _, time, z = rows(1, 60)
    slots, alone = filter.slots(), filter.start(1)
    first = slots.take()
    slots.update([first] * 60, time, z)
    slots.release(first)
    assert slots.in_use == 0 and slots.take() == first and slots.in_use == 1
    found = slots.update([first] * 30, time[:30], z[30:])
    for k in range(30):
        wanted = alone.update(time[k], z[30 + k : 31 + k])
        np.testing.assert_array_equal(found.x[k], wanted.x[0])


def test_slots_begin_at_a_given_prior():
    prior = jink.Prior(np.array([5.0, 1.0, -5.0, 2.0]), np.diag([100.0, 4.0, 100.0, 4.0]))
    filter = jink.Kalman(jink.ConstantVelocity(acceleration_sd=1.0), SENSOR, initial=prior)
    slots, alone = filter.slots(), filter.start(1)
    slot = slots.take()
    for t in (3.0, 4.0):
        found, wanted = slots.update([slot], [t], [[8.0, -2.0]]), alone.update(t, [[8.0, -2.0]])
        np.testing.assert_array_equal(found.x, wanted.x)


def test_wrong_arguments_are_named():
    slots = made("imm").slots()
    slot = slots.take()
    slots.update([slot], [1.0], [[0.0, 0.0]])
    for arguments, words in (
        (([slot + 1], [2.0], [[0.0, 0.0]]), "slot: 1 is not in use"),
        (([-1], [2.0], [[0.0, 0.0]]), "slot: -1 is not in use"),
        (([slot], [2.0, 3.0], [[0.0, 0.0]]), "t: expected shape"),
        (([slot], [2.0], [[0.0, 0.0], [1.0, 1.0]]), "z: expected shape"),
        (([slot], [2.0], [[0.0]]), "z: expected shape"),
        (([slot], [np.nan], [[0.0, 0.0]]), "t: expected a finite time"),
        (([slot], [2.0], [[np.inf, 0.0]]), "z: is infinite"),
        (([slot], [0.0], [[0.0, 0.0]]), "t: lies before"),
    ):
        with pytest.raises(ValueError, match=words):
            slots.update(*arguments)
    slots.release(slot)
    for call in (lambda: slots.release(slot), lambda: slots.update([slot], [9.0], [[0.0, 0.0]])):
        with pytest.raises(ValueError, match="not in use"):
            call()
