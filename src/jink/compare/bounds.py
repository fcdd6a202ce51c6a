"""What no filter can beat on a scenario: a filter that knows the manoeuvres, and the posterior Cramér–Rao bound.

The filter is given what the manoeuvres added to constant velocity from scan to scan. It still has to estimate the
state at the start and, if the truth has any, the acceleration noise that nobody commanded.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import metrics
from ..catalogue.purpose import Unfit
from ..checks import Array
from ..frozen import frozen
from ..models.outliers import Outliers
from ..scenarios import Simulation
from ..scenarios.truth import Kinematics
from .clairvoyant import clairvoyant as of_known_input

STILL = 1e-6  # m/s²: noise below is rounding
TRIFLE = 1e-6  # share of sd/T² that stands for no noise in a filter that needs some
VELOCITY_SD = 1e5  # m/s at the start, as good as unknown


@frozen
class Told:
    """What a filter is given: sd (m/s²) of the acceleration noise that it does not know, and the rest in words."""

    sd: float
    words: str


def told(training: Simulation) -> Told:
    """What can be given of the manoeuvres. Errors: Unfit where they are not known exactly from scan to scan."""
    if training.input is None:
        return Told(
            0.0,
            "given the whole acceleration of the smooth path, but not its initial state",
        )
    rest = (_increments(training) - _commanded(training))[:, 1:]
    if (runs := len(rest)) > 1:  # what is the same in all runs is no noise: a jump of the velocity
        rest = (rest - rest.mean(axis=0)) * np.sqrt(runs / (runs - 1))
    T = np.diff(training.time, axis=1)[..., None]
    acceleration = rest[..., 1] / T
    sd = float(acceleration.std())
    if sd < STILL:
        return Told(
            0.0,
            "given every manoeuvre of a truth without noise, but not its initial state",
        )
    if float(np.std(rest[..., 0] - T / 2 * rest[..., 1])) > 0.1 * float(np.std(T / 2 * rest[..., 1])):
        raise Unfit("the truth's noise or manoeuvres change between scans; use the scenario's own revisit time")
    if float((acceleration[:, 1:] * acceleration[:, :-1]).mean()) > 0.2 * sd * sd:
        raise Unfit("the truth's noise lasts for several scans; use the scenario's own revisit time")
    return Told(sd, f"given every manoeuvre, but not the truth's acceleration noise of {sd:.3g} m/s²")


def clairvoyant(simulation: Simulation, known: Told, outliers: Outliers | None) -> Any:
    """Estimate of the Kalman filter that is given this. Errors: Unfit for a curve without measured positions."""
    sensor = simulation.scenario.observation.sensor
    interval = simulation.scenario.schedule.interval
    first = float(np.sqrt(sensor.noise[0, 0]))
    sd = known.sd or TRIFLE * first / interval**2
    if sensor.position_only:
        manoeuvre: dict[str, Any] = {"displacement": _in_axes(displacement(simulation, known), sensor.axes or 2)}
    elif known.sd and not np.any(simulation.turn_rate):
        manoeuvre = {"input": _in_axes(simulation.input[..., None], sensor.axes or 2)[..., 0]}  # type: ignore[index]
    else:
        raise Unfit("the filter can be given a curved or jumping path exactly only where the sensor measures positions")
    return of_known_input(
        simulation.time,
        simulation.z,
        sensor=sensor,
        acceleration_sd=sd,
        velocity_sd=VELOCITY_SD,
        outliers=outliers,
        **manoeuvre,
    )


def displacement(simulation: Simulation, known: Told) -> Array:
    """What the manoeuvres added to constant velocity since the scan before, (B, S, axes, 2), m and m/s."""
    return _commanded(simulation) if known.sd else _increments(simulation)


def posterior_bound(training: Simulation, known: Told, first: int) -> dict[str, float]:
    """Position and velocity RMSE that the posterior Cramér–Rao bound allows a filter that is given this.

    With known manoeuvres the motion is linear. The information of a scan is that of a clean measurement times the
    probability of detection, averaged over the training runs. Gross outliers and misses only reduce it.
    """
    truth, seen = training.truth, training.scenario.observation
    axes, scans = truth.position.shape[2], training.time.shape[1]
    T = np.diff(training.time, axis=1, prepend=training.time[:, :1]).mean(axis=0)
    F, Q = np.zeros((2, scans, 2 * axes, 2 * axes))
    for a in range(axes):
        p, v = 2 * a, 2 * a + 1
        F[:, p, p] = F[:, v, v] = 1.0
        F[:, p, v] = T
        Q[:, p, p], Q[:, v, v] = T**4 / 4, T**2
        Q[:, p, v] = Q[:, v, p] = T**3 / 2
    J = seen.detection * metrics.information(_jacobians(seen.sensor, truth), seen.sensor.noise)
    start = np.diag([VELOCITY_SD**2] * (2 * axes))
    C = metrics.posterior_bound(F, known.sd**2 * Q, J, start)
    return {
        f"{name}_rmse": metrics.bound_rmse(C, range(offset, 2 * axes, 2), first=first)
        for offset, name in enumerate(("position", "velocity"))
    }


def _jacobians(sensor: Any, truth: Kinematics) -> Array:
    """∂h/∂x at the truth by central differences, (B, S, m, 2 axes), components px vx py vy …"""
    axes = truth.position.shape[2]
    columns = []
    for a in range(axes):
        for which, step in (("position", 1.0), ("velocity", 0.1)):
            ends = []
            for sign in (1.0, -1.0):
                moved = getattr(truth, which).copy()
                moved[..., a] += sign * step
                ends.append(sensor.observe(truth._replace(**{which: moved})))
            change = ends[0] - ends[1]
            for column, name in enumerate(sensor.components):
                if name == "azimuth":
                    change[..., column] = np.remainder(change[..., column] + np.pi, 2 * np.pi) - np.pi
            columns.append(change / (2 * step))
    return np.stack(columns, axis=-1)


def _increments(simulation: Simulation) -> Array:
    """[Δp − T v, Δv] of the truth since the scan before."""
    p, v = simulation.truth.position, simulation.truth.velocity
    T = np.diff(simulation.time, axis=1)[..., None]
    out = np.zeros((*p.shape, 2))
    out[:, 1:, :, 1] = np.diff(v, axis=1)
    out[:, 1:, :, 0] = np.diff(p, axis=1) - T * v[:, :-1]
    return out


def _commanded(simulation: Simulation) -> Array:
    """[Δp − T v, Δv] that the commanded turn and acceleration give."""
    u, rate = simulation.input, simulation.turn_rate
    assert u is not None and rate is not None
    T = np.diff(simulation.time, axis=1, prepend=simulation.time[:, :1])[..., None]
    out = np.stack([T * T / 2 * u, T * u], axis=-1)
    if np.any(rate):
        out = out + metrics.turn_displacement(simulation.truth.velocity, rate, simulation.time)
    return out


def _in_axes(values: Array, axes: int) -> Array:
    """(B, S, axes, n) with height 0 where the truth has none, or without the height the sensor does not see."""
    missing = axes - values.shape[2]
    if missing <= 0:
        return values[:, :, :axes]
    return np.concatenate([values, np.zeros((*values.shape[:2], missing, values.shape[3]))], axis=2)
