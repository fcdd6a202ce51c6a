"""What a filter answers in a race: manoeuvres are told after the filter's time is taken."""

from __future__ import annotations

import numpy as np
import pytest

import jink
from jink.compare import estimates
from jink.scenarios import by_name


@pytest.mark.parametrize("axes", [1, 2])
def test_manoeuvres_are_told_when_they_are_asked_for(monkeypatch, axes):
    simulation = by_name("random-turns").simulate(3, seed=1)
    sensor = jink.Position(sd=50.0, axes=axes)
    calm, lively = (jink.ConstantVelocity(acceleration_sd=sd) for sd in (1.0, 30.0))
    filter = jink.IMM([calm, lively], sensor, 0.9)
    once, told = estimates.probabilities, []
    monkeypatch.setattr(estimates, "probabilities", lambda *given: told.append(1) or once(*given))
    answer = estimates.filtered(filter, simulation)
    assert not told
    first = answer.manoeuvring
    assert first is not None and first.shape == simulation.time.shape
    assert np.array_equal(first, answer.manoeuvring, equal_nan=True) and len(told) == 1


def test_one_mode_tells_no_manoeuvres():
    simulation = by_name("random-turns").simulate(2, seed=1)
    filter = jink.Kalman(jink.ConstantVelocity(acceleration_sd=5.0), jink.Position(sd=50.0))
    assert estimates.filtered(filter, simulation).manoeuvring is None
