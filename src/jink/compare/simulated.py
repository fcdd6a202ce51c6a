"""A race against the truth: common random numbers, in chunks, until all runs are done or it is interrupted."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, replace
from typing import Any

import numpy as np

from .. import metrics
from ..catalogue.purpose import Named, Purpose, Unfit
from ..checks import Array
from ..frozen import frozen
from ..io.errors import InputError
from ..metrics.errors import squared
from ..models.outliers import Outliers
from ..scenarios import SCENARIOS, Scenario, Simulation
from ..tracking.lag import Lag
from . import bounds, manoeuvring, mode_jumps, near_optimal
from .adding import add_at
from .entrants import SUFFIX, Entrant, enter
from .estimates import Answer, Block, filtered, jointly, per_axis, raw
from .example import Example, example
from .filter_files import from_file
from .priors import PRIORS
from .result import INTERRUPTED, Race
from .scores import Tally, part, scored
from .source import Source, drawn
from .treated import lagged, with_noise_of

CHUNK_ROWS = 25_000  # scans that all filters see before the next ones are simulated
PER_AXIS = ("lee-2003",)  # whose source runs every filter along each axis by itself
FIRST = 2  # scans before are the start of the track by two points
LOST = 10.0  # times the position RMSE of the raw measurements, five scans in a row


@frozen
class Field:
    """What all entrants share: the scenario, what training showed, and the limit (m) of a lost track.

    told is what a clairvoyant knows; None, and why not, where that is not exact. phases: scans between changes of
    motion that all runs share; none where only one run tells.
    """

    scenario: Scenario
    purpose: Purpose
    training: Simulation
    lost_beyond: float
    first: int
    told: bounds.Told | None
    why: str = ""
    phases: mode_jumps.Phases = field(default_factory=list)


def race(
    source: Scenario | Source,
    names: list[str],
    runs: int,
    seed: int,
    *,
    first: int = FIRST,
    more: Mapping[str, Callable[[Purpose], Named]] | None = None,
    progress: Callable[[int, int], None] | None = None,
    guests: Sequence[Entrant] = (),
    lag: Lag | None = None,
) -> Race:
    """See :func:`jink.compare.compare`; more: filters beside ``FILTERS``, made as those are; guests take part as they
    are.
    """
    if isinstance(source, Scenario):
        source = drawn(source, runs, seed)
    scenario, runs = source.scenario, source.runs
    field = prepare(source, first)
    entrants: dict[str, Entrant] = {guest.name: guest for guest in guests}
    skipped: dict[str, str] = {}
    entering: list[str] = [*names, *(name for name in more or {} if name not in names)]
    for name in entering:
        try:
            if more and name in more:
                entrants[name] = Entrant(name=name, **vars(more[name](field.purpose)))
            else:
                entrants[name] = _enter(name, field, seed, runs)
        except Unfit as reason:
            skipped[name] = str(reason)
    if lag is not None:
        late, why = lagged(entrants, lag)
        entrants, skipped = entrants | late, skipped | why
    tallies = {name: Tally() for name in entrants}
    done, shown = 0, None
    try:
        for simulation in source.chunks(max(1, CHUNK_ROWS // scenario.schedule.count)):
            # all filters have seen the same runs, whenever it is interrupted
            undo = [tally.before(simulation.runs) for tally in tallies.values()]
            try:
                seen = _one_chunk(simulation, field, entrants, tallies)
            except BaseException:
                for take_back in undo:
                    take_back()
                raise
            done, shown = done + len(simulation.runs), shown or seen
            if progress:
                progress(done, runs)
    except KeyboardInterrupt:
        if not done:
            raise
    bound: dict[str, float] = {}
    try:
        if field.told:
            bound = bounds.posterior_bound(field.training, field.told, field.first)
    except KeyboardInterrupt:
        skipped["PCRB"] = INTERRUPTED
    return Race(
        scenario=scenario.name,
        words=scenario.summary,
        seen=source.seen,
        runs=done,
        asked=runs,
        seed=seed,
        entrants=entrants,
        tallies=tallies,
        skipped=skipped,
        bound=bound,
        example=shown,
        skipped_scans=field.first,
        phases=field.phases,
    )


def prepare(source: Source, first: int) -> Field:
    """Say what filters are made for, as the training runs show it."""
    scenario, training = source.scenario, source.training
    if scenario.schedule.count <= first:
        seen = f"{scenario.schedule.count} scans in {scenario.schedule.interval:g} s steps"
        raise InputError(f"{scenario.name}: {seen}; expected at least {first + 1} scans to compare filters on")
    observation = scenario.observation
    if not observation.sensor.locates:
        raise InputError(
            f"{scenario.name}: a track cannot start from one measurement of its sensor; "
            "expected a sensor that measures positions"
        )
    measured = raw(training).position
    noise = measured - training.truth.position[..., : measured.shape[2]]
    level = metrics.rmse(noise).value
    purpose = Purpose(
        name=scenario.name,
        kind=scenario.kind,
        sensor=observation.sensor,
        sd=level / noise.shape[2] ** 0.5,
        interval=scenario.schedule.interval,
        loss=(lambda filter: _loss(filter, training, first)) if source.fitted else None,
        fitted=source.fitted,
        per_axis=scenario.name in PER_AXIS,
        outliers=Outliers(share=observation.outlier_share) if observation.outlier_share else None,
        recorded=scenario.name not in SCENARIOS,
        assumed=scenario.acceleration,
    )
    try:
        told, why = bounds.told(training), ""
    except Unfit as reason:
        told, why = None, str(reason)
    phases = mode_jumps.phases(training, first) if len(training.runs) > 1 else []
    return Field(scenario, purpose, training, LOST * level, first, told, why, phases)


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
        return with_noise_of(from_file(name, field.purpose, seed, runs), field.purpose.sensor)
    entrant = enter(name, field.purpose)
    if name == "clairvoyant":
        if field.told is None:
            raise Unfit(field.why)
        bounds.clairvoyant(field.training, field.told, None)
        seen = field.scenario.observation
        loose = (
            "it is not a strict bound, because the measurements have gross outliers or a bias"
            if seen.outlier_share or seen.bias
            else ""
        )
        words = f"Kalman filter that is {field.told.words}: a lower bound, not a usable filter"
        return replace(entrant, words=words, note=loose)
    if name == "near-optimal":
        _prior(field.scenario)
    return entrant


def _prior(scenario: Scenario) -> tuple[Any, float, float]:
    """Prior, sd (m) and T (s) of the near-optimal reference. Errors: Unfit where there is none."""
    sensor, seen = scenario.observation.sensor, scenario.observation
    if scenario.name not in PRIORS:
        raise Unfit(f"it exists only for the scenarios {', '.join(PRIORS)}")
    plain = sensor.position_only and isinstance(getattr(sensor, "sd", None), int | float) and not seen.outlier_share
    if not plain or seen.bias or scenario.schedule.jitter:
        raise Unfit("it needs measured positions of one sd, without outliers, bias or jitter")
    return PRIORS[scenario.name], float(sensor.sd), scenario.schedule.interval  # type: ignore[arg-type]


def _one_chunk(
    simulation: Simulation, field: Field, entrants: dict[str, Entrant], tallies: dict[str, Tally]
) -> Example:
    """Count all filters' answers; what is shown of the first run."""
    measured, answers = raw(simulation), {}
    true = manoeuvring.Truth.of(simulation)
    for name, entrant in entrants.items():
        began = clock.perf_counter()
        answer = _answer(entrant, simulation, field, measured)
        seconds = clock.perf_counter() - began
        tally = tallies[name]
        if name != "raw":
            tally.costs.append((seconds, simulation.time.size))
        _count(tally, answer, simulation, field, measured)
        error = answer.position - simulation.truth.position[..., : answer.position.shape[2]]
        error[:, : field.first] = np.nan
        manoeuvring.count(tally, simulation.runs, error, answer.manoeuvring, true)
        if field.phases:
            mode_jumps.count(tally, simulation.runs, answer.probability)
        answers[name] = answer
    return example(simulation, answers, true.busy)


def _answer(entrant: Entrant, simulation: Simulation, field: Field, measured: Answer) -> Answer:
    if entrant.filter is not None:
        return filtered(entrant.filter, simulation)
    if entrant.name == "raw":
        return measured
    if entrant.name == "clairvoyant":
        assert field.told is not None
        return jointly(bounds.clairvoyant(simulation, field.told, field.purpose.outliers), simulation)
    prior, sd, T = _prior(simulation.scenario)
    return _reference(near_optimal(simulation.z, prior, sd=sd, T=T))


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
    add_at(tally.runs, runs, np.ones(len(runs)))
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
    for quantity in ("position", "velocity", "acceleration"):
        square = values.get(f"{quantity}_rmse")
        if square is None:
            continue
        there = np.isfinite(square)
        tally.add_curve(runs, f"{quantity}_square", np.where(there, square, 0.0))
        tally.add_curve(runs, f"{quantity}_there", there.astype(float))
        if quantity == "acceleration":  # which nobody measures
            continue
        seen, true = getattr(measured, quantity), getattr(truth, quantity)
        if seen is None:
            continue
        noise = squared(seen - true[..., : seen.shape[2]], first)
        both = np.isfinite(square) & np.isfinite(noise)
        tally.add_curve(runs, f"{quantity}_error", np.where(both, square, 0.0))
        tally.add_curve(runs, f"{quantity}_noise", np.where(both, noise, 0.0))


def _gone(error: Array, limit: float, scans: int = 5) -> Array:
    """1 for every run whose track is lost, as :func:`jink.metrics.lost` counts, else 0; (B,)."""
    square = squared(error)
    begun = np.maximum.accumulate(np.isfinite(square), axis=1)
    far = begun & ~(square <= limit * limit)
    ends = far.shape[1] - scans + 1
    if ends < 1:
        return np.zeros(len(far))
    together = np.logical_and.reduce([far[:, k : k + ends] for k in range(scans)])
    return together.any(axis=1).astype(float)
