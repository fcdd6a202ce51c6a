"""What training costs: rules by the paper's genetic algorithm, networks end to end through the filter, an ANFIS."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from jink.learn import genetic
from jink.learn.aid import inputs_of, tuned_acceleration, watch
from jink.learn.anfis import fit_anfis
from jink.learn.data import from_scenario
from jink.learn.end_to_end import train_end_to_end
from jink.learn.mixed_paths import broad
from jink.learn.modes import untrained
from jink.learn.modes_end_to_end import train_scores_end_to_end
from jink.papers.training import titi_guney
from jink.papers.training.choi_2001 import WIDE_BANK

from .targets import Row, reason

LIMITS = {  # s, on two cores
    "genetic algorithm, 500 × 100 generations, ≤ 50 rules, 10 runs × 60 scans, one sub-model": 8.0,
    "NNVSMM by parameter, end to end on targets of all kinds, 1200 steps of 128 runs": 30.0,
    "NNVSMM by mode, end to end on targets of all kinds, 120 steps of 128 runs": 30.0,
    "ANFIS of 16 rules, 3300 samples, 300 epochs": 2.0,
}


def jobs(share: float = 1.0) -> dict[str, Callable[[], Any]]:
    """Each training by its name in LIMITS; share: of its generations, steps or epochs."""

    def some(count: int) -> int:
        return max(1, round(share * count))

    training, validation = (from_scenario(broad(), n, seed) for n, seed in ((4000, 1), (1000, 2)))
    settings = genetic.Settings()
    settings = replace(settings, generations=some(settings.generations))
    runs = genetic.training_runs(10.0)
    u, y = _residuals()
    wide = {"least": 0.01, "most": 5000.0}
    made: list[Callable[[], Any]] = [
        lambda: genetic.identify(10.0, runs, settings=settings),
        lambda: train_end_to_end(training, validation, **wide, steps=some(1200), patience=1200),
        lambda: train_scores_end_to_end(
            WIDE_BANK,
            training,
            validation.take(slice(0, 500)),
            start=untrained(len(WIDE_BANK)),
            steps=some(120),
            patience=120,
        ),
        lambda: fit_anfis(u, y, epochs=some(300)),
    ]
    return dict(zip(LIMITS, made, strict=True))


def _residuals() -> tuple[Any, Any]:
    """titi-guney's training matrix: a sluggish filter's two inputs and its error, 3300 rows, scaled."""
    runs = titi_guney.runs_of((1,), 20, 1)
    seen = watch(tuned_acceleration(runs, 1e4), runs)
    u = inputs_of("titi-guney", 2, seen)[seen.updated][-3300:]
    y = (runs.position - seen.estimate["position"])[seen.updated][-3300:, None]
    return (u - u.mean(axis=0)) / u.std(axis=0), y / y.std()


def measure(share: float, rounds: int) -> dict[str, dict[str, list[float]]]:
    """Seconds by the wall clock and of all cores together, a value a round."""
    out: dict[str, dict[str, list[float]]] = {name: {"seconds": [], "cpu": []} for name in LIMITS}
    made = jobs(share)
    for _ in range(rounds):
        for name, job in made.items():
            begin = time.perf_counter(), time.process_time()
            job()
            out[name]["seconds"].append(time.perf_counter() - begin[0])
            out[name]["cpu"].append(time.process_time() - begin[1])
    return out


def rows(results: dict[str, Any]) -> list[Row]:
    """A row for each; what counts is the processor time, which other work on the machine does not add to."""
    found, out = results.get("learning", {}), []
    for name, limit in LIMITS.items():
        must = f"≤ {limit:g} s"
        if name not in found:
            out.append(Row(f"training: {name}", reason(results, "learning"), must))
            continue
        cpu, wall = min(found[name]["cpu"]), min(found[name]["seconds"])
        out.append(Row(f"training: {name}", f"{cpu:.2f} s of CPU, {wall:.2f} s", must, cpu <= limit))
    return out
