"""NNVSMM's networks: what training makes of them, the same from the same seed, files, units."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import jink
from jink.catalogue.shipped import shipped
from jink.learn import supervised
from jink.learn.data import from_scenario
from jink.learn.end_to_end import train_end_to_end
from jink.learn.mixed_paths import broad
from jink.learn.mlp import parameters_of
from jink.learn.modes import train_scores, untrained
from jink.learn.modes_end_to_end import tracking_loss, train_scores_end_to_end
from jink.papers.training.choi_2001 import BANK, _modes_filter, _noise_filter

TRAINING, VALIDATION = (from_scenario("choi-2001-mixed", n, seed) for n, seed in ((120, 1), (40, 2)))
MOTIONS = [jink.ConstantVelocity(acceleration_sd=q**0.5) for q in BANK]


def rms(filter, runs):
    x = filter.filter(**runs.batch(), outputs=("x",)).x[:, ::2].reshape(runs.z.shape)
    return float(np.sqrt(((x - runs.position)[:, 2:] ** 2).sum(axis=2).mean()))


@pytest.mark.parametrize("labels", ["published", "expected"])
def test_labels_are_learned_in_part(labels):
    """The published ones, each the best level of one run, are nearly all noise; free of it they can be told."""
    network = supervised.train_supervised(TRAINING, VALIDATION, labels=labels, epochs=40)
    make = supervised.published_pairs if labels == "published" else supervised.expected_pairs
    u, q = make(VALIDATION)
    if labels == "published":
        assert 0.9 < np.mean((network(u) - q) ** 2) / q.var() < 0.98
    else:
        assert np.corrcoef(np.log(network(u)), np.log(q))[0, 1] > 0.8
    assert network == supervised.train_supervised(TRAINING, VALIDATION, labels=labels, epochs=40)


def test_scores_follow_who_was_right():
    """A mode that knows the target better has more of the weight: on lines the quietest, on circles a louder one."""
    network = train_scores(MOTIONS, TRAINING, VALIDATION, best=3, epochs=30)
    filter = _modes_filter(network, BANK)
    shares = [
        filter.filter(**from_scenario(name, 40, 3).batch()).mode_probability.reshape(40, 20, 6)[:, 5:]
        for name in ("choi-2001-line", "choi-2001-circle")
    ]
    assert ((shares[0] > 0).sum(axis=2) == 3).all()
    line, circle = (np.log(BANK) @ share.mean(axis=(0, 1)) for share in shares)
    assert circle > line + 0.3
    assert network == train_scores(MOTIONS, TRAINING, VALIDATION, best=3, epochs=30)


def test_end_to_end_beats_what_it_began_with():
    start, few = untrained(len(BANK)), TRAINING.take(slice(0, 40))
    found = train_scores_end_to_end(BANK, few, VALIDATION, start=start, best=4, steps=10, rate=0.03)
    losses = [float(tracking_loss(parameters_of(n.network), start, BANK, VALIDATION)) for n in (start, found)]
    assert losses[1] < losses[0] - 0.02
    assert (found.best, found.centre) == (4, start.centre)
    again = train_scores_end_to_end(BANK, few, VALIDATION, start=start, best=4, steps=10, rate=0.03)
    assert again == found


def test_the_loss_that_is_differentiated_is_that_of_the_filter():
    network = untrained(len(BANK), seed=2)
    x = _modes_filter(network, BANK).filter(**VALIDATION.batch(), outputs=("x",)).x[:, ::2]
    squares = ((x.reshape(VALIDATION.z.shape) - VALIDATION.position)[:, 2:] ** 2).sum(axis=(1, 2))
    expected = np.log(squares / 18 + 1.0).mean()
    found = tracking_loss(parameters_of(network.network), network, BANK, VALIDATION)
    assert float(found) == pytest.approx(expected, rel=1e-10)


def test_training_ends_where_nothing_gets_better():
    """With steps far too long the best is soon behind: patience, then the end.

    The first network saturates at once and its loss stays the same to the bit; the second's is worse by 3e-4 and more.
    Steps of 3 leave the first on a plateau, where rounding, and so the BLAS, decides what is better.
    """
    seen = []
    settings = {"steps": 300, "seed": 1, "progress": lambda *said: seen.append(said)}
    scored = {"start": untrained(6), "patience": 10, "rate": 1.0}
    for patience, train in (
        (50, lambda: train_end_to_end(TRAINING, VALIDATION, patience=50, rate=10.0, **settings)),
        (
            10,
            lambda: train_scores_end_to_end(BANK, TRAINING.take(slice(0, 16)), VALIDATION, **scored, **settings),
        ),
    ):
        seen.clear()
        train()
        last, loss = seen[-1]
        found = next(step for step, value in seen if value == loss)
        assert last < 299 and last - found == patience


def test_interrupted_training_leaves_nothing_behind_and_runs_again_to_the_same():
    whole = train_end_to_end(TRAINING, VALIDATION, steps=40, seed=4)

    def interrupt(step, loss):
        if step > 20:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train_end_to_end(TRAINING, VALIDATION, steps=40, seed=4, progress=interrupt)
    assert train_end_to_end(TRAINING, VALIDATION, steps=40, seed=4) == whole
    assert train_end_to_end(TRAINING, VALIDATION, steps=40, seed=5) != whole


def test_targets_of_all_kinds_are_no_repetition():
    runs = from_scenario(broad(), 8, 1)
    assert len(np.unique(runs.position[:, -1].round(3), axis=0)) == 8


@pytest.mark.parametrize("name", ["choi-2001-wide", "choi-2001-published-3", "choi-2001-modes-wide"])
def test_a_network_comes_back_from_its_file_bit_for_bit(name, tmp_path):
    filter, path = shipped(name, 0), tmp_path / "network.json"
    filter.save(path)
    again = jink.load(path)
    assert again.motions == filter.motions
    if "modes" in name:
        assert again.network == filter.network and filter.network.trained is not None
    batch = from_scenario("choi-2001-4", 5, 9).batch()
    for output in ("x", "P", "mode_probability"):
        assert_array_equal(getattr(again.filter(**batch), output), getattr(filter.filter(**batch), output))


def test_a_network_of_another_sensor_is_refused_on_load(tmp_path):
    path = tmp_path / "network.json"
    shipped("choi-2001-wide", 0).save(path)
    body = json.loads(path.read_text(encoding="utf-8"))
    body["sensors"][0]["sd"] = 0.001  # the same sensor, in kilometres
    path.write_text(json.dumps(body), encoding="utf-8")
    with pytest.raises(ValueError, match=r"network\.json: NoiseNetwork: was trained on .* sd 1 m"):
        jink.load(path)


def test_a_bank_scaled_with_its_sensor_gives_a_scaled_estimate():
    """The scores see ratios alone: a target ten times as large under a sensor ten times as coarse."""
    runs, factor = from_scenario("choi-2001-3", 4, 9), 10.0
    network = shipped("choi-2001-modes-wide", 0).network
    variances = [m.acceleration_sd**2 for m in shipped("choi-2001-modes-wide", 0).motions]
    small = _modes_filter(network, tuple(variances)).filter(**runs.batch()).x
    motions = [jink.ConstantVelocity(acceleration_sd=factor * q**0.5) for q in variances]
    large = jink.NeuralModes(motions, jink.Position(sd=factor, axes=2), network)
    found = large.filter(**replace(runs, z=factor * runs.z).batch()).x
    np.testing.assert_allclose(found, factor * small, rtol=1e-8, atol=1e-6)


def test_a_shipped_noise_network_tracks_as_its_file_says():
    filter = shipped("choi-2001-wide", 0)
    said = dict(filter.motions[0].network.trained.figures)
    for k in (1, 4):
        value = rms(_noise_filter(filter.motions[0].network), from_scenario(f"choi-2001-{k}", 500, 77))
        assert value == pytest.approx(said[f"position rms, m, scenario {k}"], rel=0.03)
