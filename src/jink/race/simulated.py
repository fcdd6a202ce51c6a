"""A race on a scenario: common random numbers, in chunks, until all runs are done or it is interrupted."""

from __future__ import annotations

import copy
import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import metrics
from ..arguments import Array
from ..io.errors import InputError
from ..named import Purpose, Unfit
from ..noise import Outliers
from ..references import PRIORS, near_optimal
from ..scenarios import SCENARIOS, Scenario, Simulation
from ..sensor import Bearing, Position
from .answers import Answer, Block, filtered, jointly, per_axis, raw
from .entrants import SUFFIX, Entrant, enter
from .files import from_file
from .result import Race
from .tally import Tally, part, scored

CHUNK_ROWS = 25_000  # scans that all filters see before the next ones are simulated
TRAINING = 1 << 40  # numbers of the training runs begin here: no race reaches them
TRAINING_ROWS, TRAINING_RUNS = 36_000, 200
PER_AXIS = ("lee-2003",)  # whose source runs every filter along each axis by itself
FIRST = 2  # scans before are the start of the track by two points
LOST = 10.0  # times the position RMSE of the raw measurements, five scans in a row


@dataclass(frozen=True)
class Field:
    """What all entrants share: the scenario, what training showed, and the limit (m) of a lost track."""

    scenario: Scenario
    purpose: Purpose
    training: Simulation
    lost_beyond: float
    first: int


def race(
    scenario: Scenario,
    names: list[str],
    runs: int,
    seed: int,
    *,
    first: int = FIRST,
    progress: Callable[[int, int], None] | None = None,
    guests: Sequence[Entrant] = (),
) -> Race:
    """See :func:`jink.compare.compare`; guests take part beside the named ones."""
    field = prepare(scenario, seed, first)
    entrants: dict[str, Entrant] = {guest.name: guest for guest in guests}
    skipped: dict[str, str] = {}
    for name in names:
        try:
            entrants[name] = _enter(name, field, seed, runs)
        except Unfit as reason:
            skipped[name] = str(reason)
    tallies = {name: Tally() for name in entrants}
    done = 0
    try:
        size = max(1, CHUNK_ROWS // scenario.schedule.count)
        for simulation in scenario.chunks(runs, seed, size=size):
            following = copy.deepcopy(
                tallies
            )  # all filters have seen the same runs, whenever it is interrupted
            _one_chunk(simulation, field, entrants, following)
            tallies, done = following, done + len(simulation.runs)
            if progress:
                progress(done, runs)
    except KeyboardInterrupt:
        if not done:
            raise
    return Race(
        scenario=scenario.name,
        words=scenario.summary,
        runs=done,
        asked=runs,
        seed=seed,
        entrants=entrants,
        tallies=tallies,
        skipped=skipped,
    )


def prepare(scenario: Scenario, seed: int, first: int) -> Field:
    """Simulate the training runs and say what filters are made for."""
    scans = scenario.schedule.count
    first = min(first, scans - 1)
    count = int(np.clip(TRAINING_ROWS // scans, 20, TRAINING_RUNS))
    training = scenario.simulate(np.arange(TRAINING, TRAINING + count), seed)
    observation = scenario.observation
    sensor = observation.sensor
    if isinstance(sensor, Bearing):
        raise InputError(
            f"{scenario.name}: bearings alone start no track; a race needs a sensor of positions"
        )
    noise = raw(training).position - training.truth.position[..., : raw(training).position.shape[2]]
    level = metrics.rmse(noise).value
    purpose = Purpose(
        name=scenario.name,
        kind=scenario.kind,
        sensor=sensor,
        sd=level / noise.shape[2] ** 0.5,
        interval=scenario.schedule.interval,
        loss=lambda filter: _loss(filter, training, first),
        fitted=f"{count} training runs",
        per_axis=scenario.name in PER_AXIS,
        outliers=Outliers(share=observation.outlier_share) if observation.outlier_share else None,
        recorded=scenario.name not in SCENARIOS,
    )
    return Field(scenario, purpose, training, LOST * level, first)


def _loss(filter: Any, training: Simulation, first: int) -> float:
    """Position RMSE of a filter on the training runs; infinite where it has no estimate."""
    if per_axis(filter, training.scenario.observation.sensor):
        position = filtered(filter, training).position
    else:
        estimate = filter.filter(**training.batch(), outputs=("x",))
        index = [estimate.components.index(f"p{a}") for a in "xyz"[: filter.axes]]
        position = estimate.x[:, index].reshape(*training.time.shape, -1)
    axes = min(position.shape[2], training.truth.position.shape[2])
    value = metrics.rmse(position[..., :axes] - training.truth.position[..., :axes], first=first).value
    return value if np.isfinite(value) else np.inf


def _enter(name: str, field: Field, seed: int, runs: int) -> Entrant:
    if name.endswith(SUFFIX):
        return from_file(name, field.purpose, seed, runs)
    if name == "clairvoyant":
        _process_noise(field.training)
    if name == "near-optimal":
        _prior(field.scenario)
    return enter(name, field.purpose)


def _process_noise(training: Simulation) -> float:
    """Sd (m/s²) of the acceleration that nobody commanded. Errors: Unfit where there is no command or no noise."""
    if training.input is None or training.turn_rate is None:
        raise Unfit("the truth is a smooth curve: it has no commanded accelerations that could be known")
    if np.any(training.turn_rate) and not isinstance(training.scenario.observation.sensor, Position):
        raise Unfit("a known turn needs a sensor of positions")
    v, a = training.truth.velocity[:, :-1], training.truth.acceleration[:, :-1].copy()
    if a.shape[2] > 1:
        rate = training.turn_rate[:, 1:]
        a[..., 0] += rate * v[..., 1]
        a[..., 1] -= rate * v[..., 0]
    sd = float((a - training.input[:, 1:]).std())
    if not sd > 1e-6:
        raise Unfit(
            "the truth has no noise of its own: knowing its manoeuvres there is nothing left to estimate"
        )
    return sd


def _prior(scenario: Scenario) -> tuple[Any, float, float]:
    """Prior, sd (m) and T (s) of the near-optimal reference. Errors: Unfit where there is none."""
    sensor, seen = scenario.observation.sensor, scenario.observation
    if scenario.name not in PRIORS:
        raise Unfit(f"there is one for {', '.join(PRIORS)}")
    plain = isinstance(sensor, Position) and isinstance(sensor.sd, int | float) and not seen.outlier_share
    if not plain or seen.bias or scenario.schedule.jitter:
        raise Unfit("it needs positions of one sd without outliers, bias or jitter")
    return PRIORS[scenario.name], float(sensor.sd), scenario.schedule.interval  # type: ignore[arg-type]


def _one_chunk(
    simulation: Simulation, field: Field, entrants: dict[str, Entrant], tallies: dict[str, Tally]
) -> None:
    measured = raw(simulation)
    for name, entrant in entrants.items():
        began = clock.perf_counter()
        answer = _answer(entrant, simulation, field, measured)
        seconds = clock.perf_counter() - began
        tally = tallies[name]
        if name != "raw":
            tally.costs.append((seconds, simulation.time.size))
        _count(tally, answer, simulation, field, measured)


def _answer(entrant: Entrant, simulation: Simulation, field: Field, measured: Answer) -> Answer:
    if entrant.filter is not None:
        return filtered(entrant.filter, simulation)
    if entrant.name == "raw":
        return measured
    if entrant.name == "clairvoyant":
        return jointly(_told(simulation, _process_noise(field.training)), simulation)
    prior, sd, T = _prior(simulation.scenario)
    return _reference(near_optimal(simulation.z, prior, sd=sd, T=T))


def _told(simulation: Simulation, sd: float) -> Any:
    """The clairvoyant filter's estimate: accelerations as input, turns as known displacements."""
    sensor, u, rate = simulation.scenario.observation.sensor, simulation.input, simulation.turn_rate
    assert u is not None and rate is not None
    known: dict[str, Any] = {"input": u}
    if np.any(rate):
        T = np.diff(simulation.time, axis=1, prepend=simulation.time[:, :1])[..., None]
        displacement = metrics.turn_displacement(simulation.truth.velocity, rate, simulation.time)
        known = {"displacement": displacement + np.stack([T * T / 2 * u, T * u], axis=-1)}
    return metrics.clairvoyant(simulation.time, simulation.z, sensor=sensor, acceleration_sd=sd, **known)


def _reference(reference: Any) -> Answer:
    axes = reference.position.shape[2]
    index = [reference.components.index(f"{c}{a}") for c in "pv" for a in "xyz"[:axes]]
    return Answer(
        position=reference.position,
        velocity=reference.velocity,
        acceleration=reference.acceleration,
        blocks=(Block(range(2 * axes), reference.P, index),),
        log_likelihood=reference.log_likelihood_scan,
    )


def _count(tally: Tally, answer: Answer, simulation: Simulation, field: Field, measured: Answer) -> None:
    runs, first, truth = simulation.runs, field.first, simulation.truth
    np.add.at(tally.runs, runs % tally.groups, 1.0)
    values = scored(answer, simulation, measured, first)
    for name, each in values.items():
        tally.add(runs, name, *part(each))
    tally.add_distances(runs, np.sqrt(values["position_rmse"]))
    there = np.isfinite(values["position_rmse"])
    tally.add(runs, "estimated", there.sum(axis=1).astype(float), np.full(len(runs), float(there.shape[1])))
    axes = answer.position.shape[2]
    gone = _gone(answer.position - truth.position[..., :axes], field.lost_beyond)
    if answer is not measured:
        tally.add(runs, "lost", gone, np.ones(len(runs)))
    tally.add_curve(runs, "runs", np.ones((len(runs), 1)))
    for quantity in ("position", "velocity"):
        square = values[f"{quantity}_rmse"]
        there = np.isfinite(square)
        tally.add_curve(runs, f"{quantity}_square", np.where(there, square, 0.0))
        tally.add_curve(runs, f"{quantity}_there", there.astype(float))
        seen, true = getattr(measured, quantity), getattr(truth, quantity)
        noise = ((seen - true[..., : seen.shape[2]]) ** 2).sum(axis=2)[:, first:]
        both = np.isfinite(square) & np.isfinite(noise)
        tally.add_curve(runs, f"{quantity}_error", np.where(both, square, 0.0))
        tally.add_curve(runs, f"{quantity}_noise", np.where(both, noise, 0.0))


def _gone(error: Array, limit: float, scans: int = 5) -> Array:
    """1 for every run whose track is lost, as :func:`jink.metrics.lost` counts, else 0; (B,)."""
    square = (error**2).sum(axis=2)
    begun = np.maximum.accumulate(np.isfinite(square), axis=1)
    far = begun & ~(square <= limit * limit)
    length, gone = np.zeros(len(far)), np.zeros(len(far))
    for k in range(far.shape[1]):
        length = np.where(far[:, k], length + 1, 0)
        gone = np.where(length >= scans, 1.0, gone)
    return gone
