"""Training of corrections in the plane: what it looks at, its gradients, and that it helps on what it has not seen."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose

import jink
from jink.filters.corrected import Corrected
from jink.learn import plane
from jink.learn import plane_layers as layers
from jink.learn.plane_families import RATIO, SPREADS, family
from jink.learn.plane_inputs import inputs_of, watch

SD = 500.0


@pytest.fixture(scope="module")
def found():
    return plane.fit_plane("fighter", families=40, hidden=8, epochs=4, seed=1)


def test_the_engine_sees_what_training_sees(found):
    """Where neither range nor innovations weaken it, the correction that goes out is the network's."""
    made = jink.scenarios.by_name("random-accelerations-turned").simulate(5, 2)
    z = made.z.copy()
    z[1, 30:33] = np.nan
    z[2, 50:53] += 1e6  # a restart
    time = np.broadcast_to(made.time, z.shape[:2])
    inner = jink.default_filter("fighter", jink.Position(sd=SD))
    inner = jink.IMM(inner.motions, jink.Position(sd=SD), inner.transition, outliers=jink.Outliers(hindsight=False))
    all_of_it = replace(found, fade=1e12, trust=1e15)
    rows = {"time": time.reshape(-1), "z": z.reshape(-1, 2), "offsets": np.arange(6) * z.shape[1]}
    got = Corrected(inner, all_of_it).filter(**rows).x - inner.filter(**rows).x
    seen = watch(inner, time, z)
    even, odd, e, n = inputs_of(seen, time, z, SD**2 * np.eye(2))
    u = np.clip(np.concatenate([even, odd], axis=-1), found.low, found.high)
    u = ((u - found.centre) / found.scale).reshape(-1, even.shape[-1] + odd.shape[-1])
    taken = seen.status == jink.Status.updated
    said = np.zeros((*taken.shape, 4))
    for b in range(len(z)):  # a restart forgets
        began = np.r_[0, np.flatnonzero(seen.status[b] == jink.Status.restarted), z.shape[1]]
        for first, end in pairwise(began):
            rows = first + np.flatnonzero(taken[b, first:end])
            part = u.reshape(*taken.shape, -1)[b, rows][:, None]
            sides = np.split(part, [even.shape[-1]], axis=-1)
            said[b, rows] = layers.forward(layers.parameters(found), *sides)[0][:, 0]
    said, taken = said.reshape(-1, 4), taken.reshape(-1)
    assert 0.8 * taken.size < taken.sum() < taken.size
    for k, letter in enumerate("pv"):
        _, P = seen.block(letter)
        wanted = 0.0
        for j, d in ((0, e), (1, n)):
            sd = np.sqrt(np.einsum("bsi,bsij,bsj->bs", d, P, d))
            wanted = wanted + (said[:, 2 * k + j] * sd.reshape(-1))[:, None] * d.reshape(-1, 2)
        at = [inner.components.index(letter + axis) for axis in "xy"]
        assert_allclose(got[taken][:, at], np.asarray(wanted)[taken], rtol=1e-5, atol=2e-3)


def test_gradients_are_those_of_the_loss():
    rng = np.random.default_rng(0)
    shape = (6, 3)  # scans, tracks
    u, w, error = rng.normal(size=(*shape, 5)), rng.normal(size=(*shape, 6)), rng.normal(size=(*shape, 4))
    weight, root = rng.uniform(0.5, 1, (*shape, 4)), rng.normal(size=(*shape, 4, 4))
    weight[-1, 0] = 0
    values = [a.astype(float) for a in layers.initial(5, 3, 2, rng)]
    values[4] += 0.1  # of the factor: not at its limits
    values[7], values[9] = 20 * values[7], 20 * values[9]  # some of what is remembered is at its bound
    for inverse, which in ((0.0 * root, range(10)), (root @ root.swapaxes(-2, -1) / 9, (3, 4))):
        scans = layers.Scans(u, w, error, weight, inverse)
        found = layers.gradients(values, scans)
        for k in which:
            for at in np.ndindex(values[k].shape):
                # with a covariance the correction does not care for the NEES, so that only the factor's row is a slope
                if inverse.any() and at[0] != 2:
                    continue
                sides = []
                for step in (1e-6, -1e-6):
                    moved = [v.copy() for v in values]
                    moved[k][at] += step
                    total, count = layers.loss(moved, scans)
                    sides.append(total / count)
                assert_allclose(found[k][at], (sides[0] - sides[1]) / 2e-6, rtol=1e-4, atol=1e-7)


def test_it_helps_on_families_that_it_has_not_seen(found):
    unseen = plane.Pairs.joined(plane.drawn("fighter", 20, 77))
    position, velocity = plane.left_over(found, unseen)
    assert position < 1.0 and velocity < 0.99  # measured .996 and .974


def test_the_same_seed_gives_the_same_numbers():
    one, other = (plane.fit_plane("aircraft", families=20, hidden=3, epochs=1, seed=4).numbers() for _ in range(2))
    assert one == other


def test_without_memory_the_network_does_not_see_it():
    found = plane.fit_plane("fighter", families=20, hidden=3, epochs=1, memory=False)
    assert sum(s == 1e9 for s in found.scale) == 6


@pytest.mark.parametrize("kind", SPREADS)
def test_families_are_within_their_spread(kind):
    rng, spread = np.random.default_rng(3), SPREADS[kind]
    seen = [family(kind, rng) for _ in range(200)]
    ratios = []
    for s in seen:
        sd, interval = s.observation.sensor.sd, s.schedule.interval
        pull = getattr(s.truth, "acceleration", None) or s.truth.speed * s.truth.fastest
        ratios.append(pull * interval**2 / sd)
        widest = [spread.sd, SPREADS["fighter"].sd] if spread.harder else [spread.sd]
        assert min(w[0] for w in widest) <= sd <= max(w[1] for w in widest) * 1.001
    assert np.quantile(ratios, 0.1) < 4 * RATIO[0] and np.quantile(ratios, 0.95) > RATIO[1] / 4


def test_what_cannot_be_learned_is_refused():
    with pytest.raises(ValueError, match="random families are those of fighter, aircraft, got 'vessel'"):
        plane.fit_plane("vessel", families=20)
    with pytest.raises(ValueError, match="at least 20"):
        plane.fit_plane("fighter", families=3)
