"""What a filter answers to simulated measurements, whatever it is: estimates in the truth's axes, covariances."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from ..checks import Array
from ..frozen import frozen
from ..metrics import measured_velocity
from ..scenarios import Simulation
from ..tracking.manoeuvring import Manoeuvres, Moving, probabilities

OUTPUTS = ("x", "P", "mode_probability", "nis", "nis_dof", "log_likelihood_scan", "status")


@frozen
class Block:
    """Components [p… v…] of the error, by number, whose covariance is P[..., index, index] (B, S, n, n)."""

    columns: Sequence[int]
    P: Array
    index: Sequence[int]


@frozen
class Answer:
    """position, velocity, acceleration (B, S, axes), NaN or None where there is none; nis, nis_dof and
    log_likelihood (B, S) of the measurements; covariance as independent blocks; modes by name and their probabilities
    (B, S, M), of the first axis where filters run along each axis by themselves; tell: gives manoeuvring.
    """

    position: Array
    velocity: Array | None = None
    acceleration: Array | None = None
    blocks: tuple[Block, ...] = ()
    nis: Array | None = None
    nis_dof: Array | None = None
    log_likelihood: Array | None = None
    modes: tuple[str, ...] = ()
    probability: Array | None = None
    tell: Callable[[], Array] | None = None

    @cached_property
    def manoeuvring(self) -> Array | None:
        """The probability (B, S) of a manoeuvre as `jink track` says it, None where the modes do not tell manoeuvres.

        It is told when it is asked for, so that the time a filter takes is its own.
        """
        return None if self.tell is None else self.tell()


def raw(simulation: Simulation) -> Answer:
    """The measured positions and velocities; without the latter, backward differences of positions."""
    sensor = simulation.scenario.observation.sensor
    axes = min(sensor.axes or 2, simulation.truth.position.shape[2])
    position, velocity = sensor.positions(simulation.z)[..., :axes], sensor.velocities(simulation.z)
    if velocity is None:
        return Answer(position, measured_velocity(position, simulation.time))
    return Answer(position, velocity[..., :axes])


def filtered(filter: Any, simulation: Simulation) -> Answer:
    """A filter's estimates; one whose sensor has one axis runs along each axis by itself."""
    what = Manoeuvres.of(filter, simulation.scenario.kind)
    if per_axis(filter, simulation.scenario.observation.sensor):
        return _along_each_axis(filter, simulation, what)
    estimate = filter.filter(**simulation.batch(), outputs=OUTPUTS)
    answer = jointly(estimate, simulation)
    if not any(estimate.non_manoeuvring):
        return answer

    def tell() -> Array:
        moving = Moving.of(estimate, simulation.time.reshape(-1), _begins(simulation))
        return probabilities(moving, what)[0].reshape(simulation.time.shape)

    return replace(answer, tell=tell)


def per_axis(filter: Any, sensor: Any) -> bool:
    """Does this filter of one axis take a sensor of several, axis by axis?"""
    return sensor.position_only and sensor.axes > 1 and filter.axes == 1


def jointly(estimate: Any, simulation: Simulation) -> Answer:
    """The answer of an engine's estimate of all axes."""
    B, S = simulation.time.shape
    names = list(estimate.components)
    axes = min(sum(name[0] == "p" for name in names), simulation.truth.position.shape[2])
    x = estimate.x.reshape(B, S, -1)
    where = {c: [names.index(c + a) for a in "xyz"[:axes] if c + a in names] for c in "pva"}
    index = where["p"] + where["v"]
    P = estimate.P.reshape(B, S, len(names), len(names))
    return Answer(
        position=x[..., where["p"]],
        velocity=x[..., where["v"]],
        acceleration=x[..., where["a"]] if where["a"] else None,
        blocks=(Block(range(2 * axes), P, index),),
        nis=estimate.nis.reshape(B, S),
        nis_dof=estimate.nis_dof.reshape(B, S),
        log_likelihood=_scored(estimate).reshape(B, S),
        **_modes(estimate, (B, S)),
    )


def _modes(estimate: Any, shape: tuple[int, ...]) -> dict[str, Any]:
    """Mode probabilities, where there are several."""
    modes = tuple(estimate.modes)
    if len(modes) < 2:
        return {}
    return {"modes": modes, "probability": estimate.mode_probability.reshape(*shape, len(modes))}


def _begins(simulation: Simulation) -> np.ndarray:
    """Which of the rows (B S,) are the first of a run."""
    first = np.zeros(simulation.time.shape, bool)
    first[:, 0] = True
    return first.reshape(-1)


def _along_axes(estimate: Any, answer: Answer, variances: Array, simulation: Simulation) -> Moving:
    """What tells manoeuvres of a target whose axes are filtered by themselves; variances (B, S, axes, n)."""
    B, S, axes = answer.position.shape
    names, rows, level = list(estimate.components), B * S, slice(0, min(axes, 2))

    def each(values: Array | None) -> Array | None:
        return None if values is None else values[..., level].reshape(rows, -1).T

    def spread(name: str) -> Array | None:
        return variances[..., level, names.index(name)].mean(axis=2).reshape(rows) if name in names else None

    quiet = np.prod(1.0 - estimate.manoeuvring.reshape(B, axes, S), axis=1).reshape(rows)
    velocity, variance = each(answer.velocity), spread("vx")
    assert velocity is not None and variance is not None
    moved, known = ((velocity,), (variance,)), ((each(answer.acceleration),), (spread("ax"),))
    return Moving(simulation.time.reshape(rows), _begins(simulation), 1.0 - quiet, *moved, *known)


def _scored(estimate: Any) -> Array:
    """ln p(z) of the rows that were taken or gated; the others predict no measurement."""
    return np.where(estimate.scored, estimate.log_likelihood_scan, np.nan)


def _along_each_axis(filter: Any, simulation: Simulation, what: Manoeuvres) -> Answer:
    B, S, axes = simulation.z.shape
    estimate = filter.filter(
        np.repeat(simulation.time, axes, axis=0).reshape(-1),
        np.swapaxes(simulation.z, 1, 2).reshape(-1, 1),
        offsets=np.arange(B * axes + 1) * S,
        outputs=OUTPUTS,
    )
    names = list(estimate.components)
    x = np.moveaxis(estimate.x.reshape(B, axes, S, -1), 1, 2)
    P = estimate.P.reshape(B, axes, S, len(names), len(names))
    rows = {name: getattr(estimate, name).reshape(B, axes, S).sum(axis=1) for name in ("nis", "nis_dof")}
    rows |= _modes(estimate, (B, axes, S))
    if "probability" in rows:
        rows["probability"] = rows["probability"][:, 0]
    answer = Answer(
        position=x[..., 0],
        velocity=x[..., 1],
        acceleration=x[..., names.index("ax")] if "ax" in names else None,
        blocks=tuple(Block((a, axes + a), P[:, a], (0, 1)) for a in range(axes)),
        log_likelihood=_scored(estimate).reshape(B, axes, S).sum(axis=1),
        **rows,
    )
    if not any(estimate.non_manoeuvring):
        return answer

    def tell() -> Array:
        variances = np.moveaxis(np.einsum("basii->basi", P), 1, 2)
        return probabilities(_along_axes(estimate, answer, variances, simulation), what)[0].reshape(B, S)

    return replace(answer, tell=tell)
