# pyright: reportArgumentType=false
"""The models that come with the package: how each was trained, and the files they are in."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ..arguments import unknown
from ..corrector import Corrector
from ..filters.aided import Aided
from ..filters.fuzzy_imm import FuzzyNoise, fuzzy_imm
from ..filters.imm import IMM
from ..filters.kalman import Kalman
from ..filters.neural_vsmm import NetworkNoise, NeuralModes
from ..fuzzy import FuzzyRules
from ..motion import ConstantAcceleration, ConstantVelocity
from ..named.tuning import best_noise
from ..noise_network import NoiseNetwork
from ..sensor import Position
from ..trained import Trained
from . import aid, noise
from .broad import broad
from .data import Runs, from_scenario, joined
from .end_to_end import train_end_to_end
from .genetic import Settings, identify
from .interacting import identify_modes
from .modes import train_scores, train_scores_end_to_end, untrained
from .population import errors_of_rules, normalised
from .supervised import train_supervised

LEE_SD, TITI_SD, CHOI_SD = 500.0, 50.0, 1.0  # m
INPUTS = (1.0, 10.0, 100.0)  # m/s²: the sub-models of lee-2003
TEST_RUNS, QUICK_TEST_RUNS = 2000, 200
CHOI_SETS = {"1": "line", "2": "circle", "3": "mixed"}  # the paper's training sets


def train(name: str, seed: int = 0, quick: bool = False) -> Any:
    """The filter of this name, trained again; the same seed gives the same filter.

    quick: less of everything, to see that it runs. Errors: ValueError for a name not in `TRAINERS`.
    """
    if name not in TRAINERS:
        raise ValueError(unknown("model", name, TRAINERS))
    return TRAINERS[name](seed, quick)


def _lee(weight: float) -> Callable[[int, bool], IMM]:
    """Three sub-models by the paper's GA, its transition matrix."""

    def make(seed: int, quick: bool) -> IMM:
        settings = Settings(weight=weight, **({"generations": 10, "population": 60} if quick else {}))
        rules = [identify(each, settings=settings, seed=seed) for each in INPUTS]
        test = from_scenario("lee-2003", QUICK_TEST_RUNS if quick else TEST_RUNS, seed + 1000)
        stay = np.full((3, 3), 0.015)
        stay[np.diag_indices(3)] = 0.97
        errors = errors_of_rules(rules, test, transition=stay, probability=[0.6, 0.2, 0.2])
        return fuzzy_imm(Position(sd=LEE_SD, axes=1), [_judged(r, errors, test) for r in rules], 0.97)

    return make


def _judged(rules: FuzzyRules, errors: Any, test: Runs) -> FuzzyRules:
    assert rules.trained is not None
    position, velocity = (float(z[0]) for z in normalised(errors, test))
    figures = (*rules.trained.figures, (f"ζp, {test}", position), (f"ζv, {test}", velocity))
    return replace(rules, trained=replace(rules.trained, figures=figures, version=_version()))


def _modes(scenario: str, modes: int, rules: int) -> Callable[[int, bool], IMM | Kalman]:
    """Rules and transition matrix together, on a scenario's own runs."""

    def make(seed: int, quick: bool) -> IMM | Kalman:
        runs = from_scenario(scenario, 20 if quick else 300, seed + 5)
        found = identify_modes(runs, modes=modes, rules=rules, generations=5 if quick else 250, seed=seed)
        test = from_scenario(scenario, QUICK_TEST_RUNS if quick else TEST_RUNS, seed + 1000)
        errors = errors_of_rules(found.modes, test, transition=found.transition)
        tables = [_judged(each, errors, test) for each in found.modes]
        motions = [_fuzzy(table) for table in tables]
        sensor = Position(sd=runs.sd, axes=1)
        if modes == 1:
            return Kalman(motions[0], sensor)
        return IMM(motions, sensor, found.transition, mode_probability=np.full(modes, 1 / modes))

    return make


def _fuzzy(table: FuzzyRules) -> FuzzyNoise:
    return FuzzyNoise(ConstantVelocity(acceleration_sd=float(np.sqrt(np.mean(table.variances)))), table)


def titi_runs(targets: tuple[int, ...], runs: int, seed: int) -> Runs:
    """x (north) of benchmark aircraft, once a second for 166 s, sd 50 m."""
    return joined(
        [
            from_scenario(f"benchmark-{t}", runs, seed, sensor=TITI_SD, interval=1.0).along([1])
            for t in targets
        ]
    )


def _titi(slowness: float, model: str) -> Callable[[int, bool], Aided]:
    """Target 1's Kalman filter, its noise tuned and then divided, aided from the paper's inputs."""

    def make(seed: int, quick: bool) -> Aided:
        training, validation, test = (
            titi_runs((1,), n, seed + k) for n, k in ((20, 1), (20, 2), (20 if quick else 300, 3))
        )
        filter = tuned_acceleration(training, slowness)
        settings: dict[str, Any] = {
            "anfis": {"epochs": 20 if quick else 300},
            "network": {"epochs": 20 if quick else 600},
        }
        found = aid.fit_corrector(
            filter, training, validation, model=model, seed=seed, **settings.get(model, {})
        )
        return _aided(filter, found, {"": test}, f"{model} on the paper's inputs", training, seed)

    return make


def _history(
    model: str, count: int, axes: tuple[int, ...] = (0, 1), **settings: Any
) -> Callable[[int, bool], Aided]:
    """The tuned filter of targets 1, 3 and 5, aided from its last innovations; judged on 2, 4 and 6."""

    def make(seed: int, quick: bool) -> Aided:
        training, validation = (
            _fleet((1, 3, 5), n, seed + k) for n, k in ((6 if quick else 60, 1), (6 if quick else 30, 2))
        )
        filter = tuned_acceleration(training, 1.0)
        more = {**settings, "epochs": 3} if quick else settings
        found = aid.fit_corrector(
            filter, training, validation, model=model, inputs="innovations", count=count, seed=seed, **more
        )
        tests = {f", target {t}": titi_runs((t,), 20 if quick else 300, seed + 3) for t in (2, 4, 6)}
        return _aided(filter, found, tests, f"{model} on the last {count} innovations", training, seed)

    return make


def _fleet(targets: tuple[int, ...], runs: int, seed: int) -> Runs:
    """East and north of benchmark aircraft, every axis a run."""
    return joined(
        [
            from_scenario(f"benchmark-{t}", runs, seed, sensor=TITI_SD, interval=1.0)
            .along([0, 1])
            .axes_apart()
            for t in targets
        ]
    )


def tuned_acceleration(training: Runs, slowness: float) -> Kalman:
    """The constant-acceleration filter with the least position error on the runs, its noise then divided by slowness."""
    sensor = Position(sd=training.sd, axes=1)

    def made(q: float) -> Kalman:
        return Kalman(ConstantAcceleration(jerk_psd=q, acceleration_prior_sd=10.0), sensor)

    q = best_noise(lambda q: float(aid.position_rms(made(q), training)[0]), 1e-3, 1e4)
    return made(q / slowness)


def _aided(
    filter: Kalman, found: Corrector, tests: dict[str, Runs], method: str, training: Runs, seed: int
) -> Aided:
    figures = []
    for words, test in tests.items():
        alone, aided = (float(aid.position_rms(filter, test, c)[0]) for c in (None, found))
        figures += [
            (f"position rms, m, filter alone{words}", alone),
            (f"position rms, m, aided{words}", aided),
        ]
    trained = Trained(data=str(training), method=method, seeds=(seed,), figures=figures, version=_version())
    return Aided(filter, replace(found, trained=trained))


def _choi(scenario: str, kind: str) -> Callable[[int, bool], Kalman]:
    """A noise network, supervised on a training set or end to end in the paper's range of noise or a wide one."""

    def make(seed: int, quick: bool) -> Kalman:
        source = broad() if scenario == "broad" else f"choi-2001-{scenario}"
        end_to_end = kind in ("end-to-end", "wide")
        runs = (200 if quick else 4000) if end_to_end else 1600 if kind == "expected" and not quick else 400
        training, validation = (
            from_scenario(source, n, 2 * seed + k) for n, k in ((runs, 1), (runs // 4, 2))
        )
        if end_to_end:
            least, most, steps = (0.01, 5000.0, 2000) if kind == "wide" else (1.0, 196.0, 600)
            network = train_end_to_end(
                training, validation, least=least, most=most, steps=20 if quick else steps, seed=seed
            )
        else:
            network = train_supervised(
                training, validation, labels=kind, epochs=10 if quick else 200, seed=seed
            )
        return _network_filter(network, training, kind, seed, quick)

    return make


def _network_filter(network: NoiseNetwork, training: Runs, kind: str, seed: int, quick: bool) -> Kalman:
    figures = []
    for k in range(1, 5):
        test = from_scenario(f"choi-2001-{k}", QUICK_TEST_RUNS if quick else TEST_RUNS, seed + 1000)
        figures.append((f"position rms, m, scenario {k}", noise.position_rms(network, test)))
    trained = Trained(
        data=str(training), method=f"{kind} training", seeds=(seed,), figures=figures, version=_version()
    )
    motion = NetworkNoise(ConstantVelocity(acceleration_sd=1.0), replace(network, trained=trained))
    return Kalman(motion, Position(sd=CHOI_SD, axes=2))


def _modes_network(kind: str) -> Callable[[int, bool], NeuralModes]:
    """Scores of constant-velocity modes: by labels on the paper's training set 3, or end to end on targets of all kinds."""
    variances = PAPER_MODES if kind == "labels" else WIDE_MODES

    def make(seed: int, quick: bool) -> NeuralModes:
        source = "choi-2001-mixed" if kind == "labels" else broad()
        training, validation = (
            from_scenario(source, n // 10 if quick else n, 2 * seed + k) for n, k in ((2000, 1), (200, 2))
        )
        motions = [ConstantVelocity(acceleration_sd=q**0.5) for q in variances]
        if kind == "labels":
            network = train_scores(
                motions,
                training.take(slice(0, 400)),
                validation,
                best=3,
                epochs=5 if quick else 100,
                seed=seed,
            )
        else:
            network = train_scores_end_to_end(
                variances,
                training,
                validation,
                start=untrained(len(variances), seed=seed),
                steps=5 if quick else 120,
                seed=seed,
            )
        sensor = Position(sd=CHOI_SD, axes=2)
        figures = []
        for k in range(1, 5):
            test = from_scenario(f"choi-2001-{k}", QUICK_TEST_RUNS if quick else TEST_RUNS, seed + 1000)
            x = NeuralModes(motions, sensor, network).filter(**test.batch(), outputs=("x",)).x[:, ::2]
            error = (x.reshape(test.z.shape) - test.position)[:, 2:]
            figures.append((f"position rms, m, scenario {k}", float(np.sqrt((error**2).sum(axis=2).mean()))))
        method = "labels from a bank" if kind == "labels" else "end to end on the tracking error"
        trained = Trained(
            data=str(training), method=method, seeds=(seed,), figures=figures, version=_version()
        )
        return NeuralModes(motions, sensor, replace(network, trained=trained))

    return make


def _version() -> str:
    from .. import __version__

    return __version__


PAPER_MODES = (1.0, 6.0, 16.0, 41.0, 91.0, 196.0)  # m²/s⁴
WIDE_MODES = (0.01, 0.3, 8.0, 200.0, 5000.0)
CHOI: dict[str, Callable[[int, bool], Any]] = {
    **{f"choi-2001-published-{k}": _choi(name, "published") for k, name in CHOI_SETS.items()},
    "choi-2001-expected": _choi("mixed", "expected"),
    "choi-2001-end-to-end": _choi("mixed", "end-to-end"),
    "choi-2001-wide": _choi("broad", "wide"),
}
TITI: dict[str, Callable[[int, bool], Any]] = {
    f"titi-guney-{speed}-{model}": _titi(slowness, model)
    for speed, slowness in (("sluggish", 1e4), ("tuned", 1.0))
    for model in ("linear", "anfis", "network")
}
TRAINERS: dict[str, Callable[[int, bool], Any]] = {
    "lee-2003-ga": _lee(0.95),
    "lee-2003-ga-error": _lee(1.0),
    "lee-2003-best": _modes("lee-2003", 3, 2),
    "fuzzy-kalman": _modes("random-accelerations", 1, 6),
    **TITI,
    "nn-kf": _history("network", 8, hidden=(32,), epochs=60, batch=1024),
    "anfis-kf": _history("anfis", 4, functions=2, kind="gaussian", epochs=40),
    "choi-2001-modes": _modes_network("labels"),
    "nnvsmm-modes": _modes_network("end-to-end"),
    **CHOI,
}
SEEDS = range(5)  # of the models of choi-2001, where one training is a lottery
