"""How the aids that come with the package were trained: as in titi-guney, and fed by the last innovations."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ...catalogue.interacting import imm
from ...catalogue.purpose import Purpose
from ...filters.aided import Aided
from ...filters.imm import IMM
from ...filters.kalman import Kalman
from ...learn import aid
from ...learn.data import Runs, from_scenario, joined
from ...learn.recipes import ANFIS, COUNTS, SEEN
from ...models.corrector import Corrector
from ...models.provenance import VERSION, Trained
from ...models.sensor import Position
from .trainer import Trainer

SD = 50.0  # m
KIND = "fighter"  # what the benchmark's aircraft count as


def runs_of(targets: tuple[int, ...], runs: int, seed: int, interval: float = 1.0) -> Runs:
    """x (north) of benchmark aircraft, all 185 s, sd 50 m."""
    return joined(
        [from_scenario(f"benchmark-{t}", runs, seed, sensor=SD, interval=interval).along([1]) for t in targets]
    )


# what the paper says of its ANFIS
LITERAL: dict[str, Any] = {"functions": 4, "kind": "triangular", "method": "backpropagation", "epochs": 10}


def as_published(slowness: float, model: str, interval: float = 1.0) -> Trainer:
    """Target 1's Kalman filter, its noise tuned and then divided, aided from the paper's inputs.

    Trained on 20 runs of a scan a second, or on 4 of twenty, with as many steps of the network on either. model
    "literal" is the paper's ANFIS, ten epochs of backpropagation; "anfis" the same with 300 of the hybrid method.
    """
    often = interval < 1
    counts = (4, 4, 30) if often else (20, 20, 300)
    epochs = {"anfis": 300, "network": 120 if often else 600}

    def make(seed: int, quick: bool) -> Aided:
        training, validation, test = (
            runs_of((1,), min(n, 20) if quick else n, seed + k, interval) for k, n in enumerate(counts, start=1)
        )
        filter = aid.tuned_acceleration(training, slowness)
        settings = dict(LITERAL) if model == "literal" else {}
        kind = "anfis" if model == "literal" else model
        if model in epochs:
            settings["epochs"] = min(epochs[model], 20) if quick else epochs[model]
        found = aid.fit_corrector(filter, training, validation, model=kind, seed=seed, **settings)
        return _aided(filter, found, {"": test}, f"{model} on the paper's inputs", training, seed)

    return make


def fed_by_history(model: str, inputs: str, **settings: Any) -> Trainer:
    """The tuned filter of targets 1, 3 and 5, aided from its last innovations; judged on 2, 4 and 6."""

    def make(seed: int, quick: bool) -> Aided:
        training, validation = (
            _fleet((1, 3, 5), n, seed + k) for n, k in ((6 if quick else 60, 1), (6 if quick else 30, 2))
        )
        filter = aid.tuned_acceleration(training, 1.0)
        more = {**settings, "epochs": 3} if quick else settings
        found = aid.fit_corrector(
            filter, training, validation, model=model, inputs=inputs, count=COUNTS[inputs], seed=seed, **more
        )
        found, gains = aid.weakened(filter, validation, found)
        tests = {f", target {t}": runs_of((t,), 20 if quick else 300, seed + 3) for t in (2, 4, 6)}
        return _aided(filter, found, tests, f"{model} on {SEEN[inputs]}, gain {gains[0]:.2f}", training, seed)

    return make


def on_the_imm(model: str) -> Trainer:
    """Aids of jink's default IMM of one axis: "literal" and "anfis" as :func:`as_published`, "history" as
    :func:`fed_by_history`.
    """

    def make(seed: int, quick: bool) -> Aided:
        base = imm(Purpose(sensor=Position(sd=SD, axes=1), kind=KIND, sd=SD)).filter
        if model == "history":
            training, validation = (_with_weaving(6 if quick else n, seed + k) for n, k in ((30, 1), (30, 2)))
            settings: dict[str, Any] = {"inputs": "sums", "count": COUNTS["sums"], **ANFIS["sums"]}
        else:
            training, validation = (runs_of((1,), 20, seed + k) for k in (1, 2))
            settings = dict(LITERAL) if model == "literal" else {"epochs": 300}
        if quick:
            settings["epochs"] = 3
        found = aid.fit_corrector(base, training, validation, seed=seed, **settings)
        tests = {f", target {t}": runs_of((t,), 20 if quick else 300, seed + 3) for t in (1, 2, 4, 6)}
        seen = "the paper's inputs"
        if model == "history":
            found, gains = aid.weakened(base, validation, found)
            seen = f"{SEEN['sums']}, gain {gains[0]:.2f}"
        return _aided(base, found, tests, f"ANFIS on {seen}", training, seed)

    return make


def _fleet(targets: tuple[int, ...], runs: int, seed: int) -> Runs:
    """East and north of benchmark aircraft, every axis a run."""
    return joined(
        [
            from_scenario(f"benchmark-{t}", runs, seed, sensor=SD, interval=1.0).along([0, 1]).axes_apart()
            for t in targets
        ]
    )


def _with_weaving(runs: int, seed: int) -> Runs:
    """East and north of targets 1, 3 and 5 and of a fighter that weaves, which pulls as hard as target 6."""
    weaving = from_scenario("weave", runs, seed, sensor=SD, interval=1.0).along([0, 1]).axes_apart()
    return joined([_fleet((1, 3, 5), runs, seed), weaving])


def _aided(
    filter: Kalman | IMM, found: Corrector, tests: dict[str, Runs], method: str, training: Runs, seed: int
) -> Aided:
    figures = []
    for words, test in tests.items():
        alone, aided = (float(aid.position_rms(filter, test, c)[0]) for c in (None, found))
        figures += [
            (f"position rms, m, filter alone{words}", alone),
            (f"position rms, m, aided{words}", aided),
        ]
    trained = Trained(data=str(training), method=method, seeds=(seed,), figures=figures, version=VERSION)
    return Aided(filter, replace(found, trained=trained))
