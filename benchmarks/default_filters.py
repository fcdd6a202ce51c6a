"""The default filters on what they are for: real flights (ADS-B, and simulated radars), simulated vessels and drones.

    python -m benchmarks.default_filters [FLIGHTS]

Every default races a constant-velocity Kalman filter and a CV + CA IMM whose noises are fitted (by a search on the
likelihood) on other flights or runs than those it is measured on. FLIGHTS: examples/flights.parquet, or the whole quickstart collection.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.optimize import minimize
from scipy.stats import chi2

import jink
from benchmarks.flights import RADARS, SETTLED, Tracks, ads_b, flights, held_out, radar
from jink.kinds import default_filter
from jink.scenarios import SCENARIOS

START = {"velocity_sd": 200.0}
Build = Callable[[np.ndarray], object]


def constant_velocity(sensor: jink.Position, outliers: jink.Outliers) -> tuple[Build, list[float]]:
    """log10 of the horizontal and the vertical noise."""

    def build(p: np.ndarray) -> object:
        psd = [10.0 ** p[0], 10.0 ** p[0], 10.0 ** p[1]][: sensor.axes]
        return jink.Kalman(jink.ConstantVelocity(acceleration_psd=psd), sensor, outliers=outliers)

    return build, [0.5, -0.5]


def two_modes(sensor: jink.Position, outliers: jink.Outliers) -> tuple[Build, list[float]]:
    """log10 of quiet noise, jerk, acceleration prior (horizontal), of the vertical's share, and of both sojourn times."""

    def build(p: np.ndarray) -> object:
        q, jerk, prior, up, stay, busy = 10.0 ** np.clip(p, -6, 6)
        each = np.array([1.0, 1.0, up])[: sensor.axes]
        motions = [
            jink.ConstantVelocity(acceleration_psd=q * each),
            jink.ConstantAcceleration(jerk_psd=jerk * each, acceleration_prior_sd=np.sqrt(each) * prior),
        ]
        return jink.IMM(motions, sensor, jink.Sojourn([stay, busy]), outliers=outliers)

    return build, [-2.0, -1.0, -0.3, -0.7, 1.7, 1.2]


def likelihood(bank: object, data: Tracks, threads: int = 1) -> float:
    """Mean log-likelihood per row."""
    found = bank.filter(
        data.time,
        data.z,
        offsets=data.offsets,
        covariance=data.covariance,
        threads=threads,
        outputs=("log_likelihood",),
    )
    return float(found.log_likelihood.sum() / len(data.time))


def fitted(maker: Callable[..., tuple[Build, list[float]]], data: Tracks, outliers: jink.Outliers) -> object:
    """The filter of the greatest likelihood on training data."""
    build, start = maker(data.sensor, outliers)
    found = minimize(
        lambda p: -likelihood(build(p), data),
        start,
        method="Nelder-Mead",
        options={"maxfev": 120, "xatol": 0.03, "fatol": 1e-3},
    )
    return build(found.x)


def row(name: str, bank: object, data: Tracks) -> str:
    """One line of the table: everything on held-out data."""
    est = bank.filter(
        data.time,
        data.z,
        offsets=data.offsets,
        covariance=data.covariance,
        outputs=("x", "log_likelihood", "nis", "nis_dof", "status"),
    )
    age = np.arange(len(data.time)) - np.repeat(data.offsets[:-1], np.diff(data.offsets))
    places = [est.components.index(f"p{axis}") for axis in "xyz"[: data.z.shape[1]]]
    error = np.sqrt(((est.x[:, places] - data.truth) ** 2).sum(axis=1))
    scored = np.isfinite(error) & (age >= SETTLED)
    error = np.sort(error[scored])
    valid = np.isfinite(est.nis)
    low, high = chi2.ppf([0.025, 0.975], est.nis_dof[valid][:, None]).T
    inside = np.mean((est.nis[valid] >= low) & (est.nis[valid] <= high))
    gated = np.mean(np.isin(est.status, (3, 4)))
    rmse = np.sqrt((error[: int(0.99 * len(error))] ** 2).mean())
    return (
        f"  {name:<24}{est.log_likelihood.sum() / len(data.time):9.3f}{rmse:9.1f}{np.median(error):9.1f}"
        f"{error[int(0.95 * len(error))]:9.1f}{100 * inside:9.1f}{100 * gated:9.3f}"
    )


def race(title: str, kind: str, train: Tracks, test: Tracks) -> None:
    """Print one table."""
    default = default_filter(kind, train.sensor)
    print(f"{title}: {len(test.time)} rows held out")
    print(f"  {'':<24}{'log-lik.':>9}{'RMSE 99%':>9}{'median':>9}{'95%':>9}{'NIS in %':>9}{'gated %':>9}")
    for name, maker in (("CV, fitted", constant_velocity), ("IMM CV + CA, fitted", two_modes)):
        print(row(name, fitted(maker, train, default.outliers), test), flush=True)
    print(row(f"default, {kind}", default, test), flush=True)


def simulated(name: str, runs: range, seed: int) -> Tracks:
    """Runs of a scenario."""
    made = SCENARIOS[name].simulate(runs, seed)
    batch = made.batch()
    n = made.z.shape[1]
    return Tracks(
        made.scenario.observation.sensor,
        batch["time"],
        batch["z"],
        made.truth.position.reshape(-1, made.z.shape[2]),
        np.arange(len(runs) + 1) * n,
    )


def main() -> None:
    """Print all tables."""
    path = Path(sys.argv[1] if len(sys.argv) > 1 else "examples/flights.parquet")
    known = flights(path)
    train, test = [f for f in known if not held_out(f)], [f for f in known if held_out(f)]
    print(f"{len(train)} flights to fit the rivals, {len(test)} held out; errors in metres")
    race("ADS-B as received (error against the position itself)", "aircraft", ads_b(train), ads_b(test))
    for name in RADARS:
        race(name, "aircraft", radar(train, name, 1), radar(test, name, 2))
    for name in ("vessel", "drone"):
        race(f"scenario {name}", name, simulated(name, range(60), 1), simulated(name, range(60, 260), 1))


if __name__ == "__main__":
    main()
