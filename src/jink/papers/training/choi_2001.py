"""How the networks of NNVSMM that come with the package were trained: supervised as in choi-2001, and end to end."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...filters.kalman import Kalman
from ...filters.neural_vsmm import NetworkNoise, NeuralModes
from ...learn.data import Runs, from_scenario
from ...learn.end_to_end import train_end_to_end
from ...learn.mixed_paths import broad
from ...learn.modes import train_scores
from ...learn.modes_end_to_end import train_scores_end_to_end
from ...learn.supervised import train_supervised
from ...models.motion import ConstantAcceleration, ConstantVelocity, CoordinatedTurn, Motion
from ...models.noise_network import ModeNetwork, NoiseNetwork
from ...models.provenance import VERSION, Trained
from ...models.sensor import Position
from .trainer import Trainer, test_runs

SD = 1.0  # m
BANK = (1.0, 6.0, 16.0, 41.0, 91.0, 196.0)  # m²/s⁴: six of the paper's forty levels
WIDE_BANK = (0.01, 0.3, 8.0, 200.0, 5000.0)
MOTIONS: list[Motion] = [
    *(ConstantVelocity(acceleration_sd=sd) for sd in (0.1, 14.0, 70.0)),
    ConstantAcceleration(jerk_psd=100.0, acceleration_prior_sd=45.0),
    CoordinatedTurn(acceleration_psd=1.0, turn_rate_psd=1e-4, turn_rate_prior_sd=0.3),
]
BEST = 3  # modes that share the estimate
Built = Kalman | NeuralModes


def _source(scenario: str, runs: int, seed: int) -> tuple[Runs, Runs]:
    """Training runs of a training set, or of targets of all kinds, and a quarter as many to choose by."""
    source = broad() if scenario == "broad" else f"choi-2001-{scenario}"
    training, validation = (from_scenario(source, n, 2 * seed + k) for n, k in ((runs, 1), (runs // 4, 2)))
    return training, validation


def supervised(scenario: str, labels: str) -> Trainer:
    """A noise network on labels of a training set."""

    def make(seed: int, quick: bool) -> Kalman:
        training, validation = _source(scenario, 400 if quick or labels == "published" else 1600, seed)
        epochs = 10 if quick else 200
        network = train_supervised(training, validation, labels=labels, epochs=epochs, seed=seed)
        trained = _trained(training, f"{labels} labels", seed, _noise_filter(network), quick)
        return _noise_filter(replace(network, trained=trained))

    return make


def end_to_end(scenario: str, least: float, most: float, steps: int, velocity_share: float = 0.0) -> Trainer:
    """A noise network on the tracking error, for noises in this range."""

    def make(seed: int, quick: bool) -> Kalman:
        training, validation = _source(scenario, 200 if quick else 4000, seed)
        network = train_end_to_end(
            training,
            validation,
            least=least,
            most=most,
            steps=20 if quick else steps,
            seed=seed,
            velocity_share=velocity_share,
        )
        method = "end to end on the tracking error"
        if velocity_share:
            method += f", {velocity_share:.0%} of it the velocity's"
        trained = _trained(training, method, seed, _noise_filter(network), quick)
        return _noise_filter(replace(network, trained=trained))

    return make


def modes_supervised(scenario: str) -> Trainer:
    """Scores of the bank's modes on labels of a training set; the best three share the estimate."""

    def make(seed: int, quick: bool) -> NeuralModes:
        training, validation = _source(scenario, 400, seed)
        epochs = 5 if quick else 100
        network = train_scores(_motions(BANK), training, validation, best=BEST, epochs=epochs, seed=seed)
        trained = _trained(training, "labels from the bank", seed, _modes_filter(network, BANK), quick)
        return _modes_filter(replace(network, trained=trained), BANK)

    return make


def modes_of_motion(seed: int, quick: bool) -> NeuralModes:
    """Scores of constant velocities, an acceleration and a turn on labels of targets of all kinds; the best three share
    the estimate.
    """
    training, validation = _source("broad", 200 if quick else 1000, seed)
    epochs = 5 if quick else 40
    network = train_scores(MOTIONS, training, validation, best=BEST, epochs=epochs, seed=seed)
    filter = NeuralModes(MOTIONS, Position(sd=SD, axes=2), network)
    trained = _trained(training, "labels from the bank", seed, filter, quick)
    return NeuralModes(MOTIONS, Position(sd=SD, axes=2), replace(network, trained=trained))


def modes_end_to_end(scenario: str, variances: tuple[float, ...]) -> Trainer:
    """Scores that start from labels and are made better on the tracking error through all modes; the best three share
    the estimate.
    """

    def make(seed: int, quick: bool) -> NeuralModes:
        training, validation = _source(scenario, 200 if quick else 2000, seed)
        few = training.take(slice(0, 400))
        start = train_scores(_motions(variances), few, validation, epochs=5 if quick else 100, seed=seed)
        network = train_scores_end_to_end(
            variances, training, validation, start=start, best=BEST, steps=5 if quick else 120, seed=seed
        )
        filter = _modes_filter(network, variances)
        trained = _trained(training, "end to end on the tracking error", seed, filter, quick)
        return _modes_filter(replace(network, trained=trained), variances)

    return make


def _motions(variances: tuple[float, ...]) -> list[ConstantVelocity]:
    return [ConstantVelocity(acceleration_sd=q**0.5) for q in variances]


def _modes_filter(network: ModeNetwork, variances: tuple[float, ...]) -> NeuralModes:
    return NeuralModes(_motions(variances), Position(sd=SD, axes=2), network)


def _noise_filter(network: NoiseNetwork) -> Kalman:
    motion = NetworkNoise(ConstantVelocity(acceleration_sd=1.0), network)
    return Kalman(motion, Position(sd=SD, axes=2))


def _trained(training: Runs, method: str, seed: int, filter: Built, quick: bool) -> Trained:
    """With what the filter reaches on fresh runs of the paper's four test scenarios."""
    figures = []
    for k in range(1, 5):
        test = from_scenario(f"choi-2001-{k}", test_runs(quick), seed + 1000)
        said = filter.filter(**test.batch(), outputs=("x",))
        x = said.x[:, [said.components.index(name) for name in ("px", "py")]]
        error = (x.reshape(test.z.shape) - test.position)[:, 2:]
        figures.append((f"position rms, m, scenario {k}", float(np.sqrt((error**2).sum(axis=2).mean()))))
    return Trained(data=str(training), method=method, seeds=(seed,), figures=figures, version=VERSION)
