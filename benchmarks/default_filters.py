"""The default filters on what they are for: real flights (ADS-B, and simulated radars), and simulated targets.

    python -m benchmarks.default_filters [FLIGHTS]     (without FLIGHTS the whole quickstart collection, fetched once)

Every default races a constant-velocity Kalman filter and a CV + CA IMM whose noises are fitted (by a search on the
likelihood) on other flights or runs than those it is measured on.
Predictions are of the next position, horizontally; RMSE is of filtered positions, without the worst 1%.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.optimize import minimize
from scipy.stats import chi2

import jink
from benchmarks.commands import fetch_collection
from benchmarks.flights import RADARS, SETTLED, Tracks, ads_b, flights, held_out, radar
from jink import default_filter
from jink.scenarios import SCENARIOS, Observation, Scenario, Schedule
from jink.scenarios.random import RandomTurns

TURNING, QUIET = 0.15 * 9.80665, 0.03 * 9.80665  # m/s²: a flight clearly manoeuvres above, and does not below
Build = Callable[[np.ndarray], object]


def constant_velocity(sensor: jink.Position, outliers: jink.Outliers) -> tuple[Build, list[float]]:
    """log10 of the horizontal and the vertical noise."""

    def build(p: np.ndarray) -> object:
        psd = [10.0 ** p[0], 10.0 ** p[0], 10.0 ** p[1]][: sensor.axes]
        return jink.Kalman(jink.ConstantVelocity(acceleration_psd=psd), sensor, outliers=outliers)

    return build, [0.5, -0.5]


def two_modes(sensor: jink.Position, outliers: jink.Outliers) -> tuple[Build, list[float]]:
    """log10 of quiet noise, jerk, acceleration prior (horizontal), of the vertical's share, and of both sojourn
    times.
    """

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


def ahead(bank: object, data: Tracks) -> np.ndarray:
    """Horizontal distances of predicted from true positions, in settled tracks, sorted."""
    both = data.with_predictions()
    est = bank.filter(**both.batch(), outputs=("x",))
    off = np.hypot(est["px"] - both.truth[:, 0], est["py"] - both.truth[:, 1])[::2]
    return np.sort(off[np.isfinite(off) & (age(data) >= SETTLED)])


def age(data: Tracks) -> np.ndarray:
    """Rows since the track began."""
    return np.arange(len(data.time)) - np.repeat(data.offsets[:-1], np.diff(data.offsets))


def trimmed(est: object, data: Tracks) -> float:
    """RMSE over all axes of the estimates' positions, without the worst 1%."""
    places = [est.components.index(f"p{axis}") for axis in "xyz"[: data.z.shape[1]]]
    error = np.sqrt(((est.x[:, places] - data.truth) ** 2).sum(axis=1))
    error = np.sort(error[np.isfinite(error) & (age(data) >= SETTLED)])
    return float(np.sqrt((error[: int(0.99 * len(error))] ** 2).mean()))


def row(name: str, bank: object, data: Tracks) -> str:
    """One line of the table: everything on held-out data."""
    est = bank.filter(**data.batch(), outputs=("x", "log_likelihood", "nis", "nis_dof", "status"))
    valid = np.isfinite(est.nis)
    low, high = chi2.ppf([0.025, 0.975], est.nis_dof[valid][:, None]).T
    inside = np.mean((est.nis[valid] >= low) & (est.nis[valid] <= high))
    gated = np.mean(np.isin(est.status, (3, 4)))
    off = ahead(bank, data)
    return (
        f"  {name:<22}{est.log_likelihood.sum() / len(data.time):9.3f}{np.median(off):9.1f}"
        f"{off[int(0.95 * len(off))]:9.1f}{trimmed(est, data):9.1f}{100 * inside:9.1f}{100 * gated:9.3f}"
    )


def race(title: str, kind: str, train: Tracks, test: Tracks) -> None:
    """Print one table."""
    default = default_filter(kind, train.sensor)
    print(f"{title}: {len(test.time)} rows held out")
    print(f"  {'':<22}{'log-lik.':>9}{'pred. 50':>9}{'95%':>9}{'RMSE':>9}{'NIS in %':>9}{'gated %':>9}")
    for name, maker in (("CV, fitted", constant_velocity), ("IMM CV + CA, fitted", two_modes)):
        print(row(name, fitted(maker, train, default.outliers), test), flush=True)
    print(row(f"default, {kind}", default, test))
    gain = [trimmed(verb(**test.batch()), test) for verb in (default.smooth, default.filter)]
    print(f"  smoothed RMSE is {gain[0] / gain[1]:.2f} of the filtered", flush=True)


def manoeuvring(data: Tracks) -> str:
    """The default's probability of manoeuvring, filtered and smoothed, where flights turn and where they do not."""
    size = np.linalg.norm(data.acceleration, axis=1)
    default, words = default_filter("aircraft", data.sensor), []
    for name, verb in (("filtered", default.filter), ("smoothed", default.smooth)):
        busy = 1.0 - verb(**data.batch()).mode_probability[:, 0]
        settled = np.isfinite(busy) & (age(data) >= SETTLED)
        turning, quiet = (busy[settled & where].mean() for where in (size > TURNING, size < QUIET))
        words.append(f"{name} {turning:.2f} / {quiet:.2f}")
    return f"  mean probability of manoeuvring, above .15 g / below .03 g: {', '.join(words)}"


def simulated(scenario: Scenario, runs: range) -> Tracks:
    """Runs of a scenario, laid end to end."""
    made = scenario.simulate(runs, 1)
    truth = made.truth.position.reshape(-1, made.truth.position.shape[2])
    batch = made.batch()
    return Tracks(made.scenario.observation.sensor, batch["time"], batch["z"], truth, batch["offsets"])


def turns(kind: str, truth: RandomTurns, sd: float, interval: float) -> Scenario:
    """Straight legs and turns as simple as can be, for the kinds that have no scenario of their own."""
    seen, count = Observation(sensor=jink.Position(sd=sd)), int(truth.duration / interval) - 1
    schedule = Schedule(start=interval, interval=interval, count=count)
    return Scenario(name=f"{kind} turns", summary="", truth=truth, observation=seen, schedule=schedule, kind=kind)


def targets() -> list[tuple[str, Scenario]]:
    """What is simulated: title and scenario."""
    rad = np.radians
    light = RandomTurns(
        speed=50.0,
        straight_mean=60.0,
        turn_mean=20.0,
        slowest=rad(2),
        fastest=rad(8),
        noise_sd=0.3,
        duration=600,
    )
    car = RandomTurns(
        speed=12.0,
        straight_mean=25.0,
        turn_mean=5.0,
        slowest=rad(8),
        fastest=rad(20),
        noise_sd=0.3,
        duration=300,
    )
    walk = RandomTurns(
        speed=1.4,
        straight_mean=20.0,
        turn_mean=3.0,
        slowest=rad(15),
        fastest=rad(60),
        noise_sd=0.1,
        duration=300,
    )
    airport = SCENARIOS["terminal-area"].seen_by(jink.Position(sd=(50.0, 50.0, 10.0), axes=3))
    return [
        ("scenario terminal-area, 50 m every 4 s", airport),
        (
            "light aircraft, 50 m/s, turns of 2-8 degrees/s, 30 m every 4 s",
            turns("aircraft", light, 30.0, 4.0),
        ),
        ("scenario vessel, 10 m every 10 s", SCENARIOS["vessel"]),
        ("scenario drone, 2 m every 0.5 s", SCENARIOS["drone"]),
        ("car, 12 m/s, turns of 8-20 degrees/s, 4 m every second", turns("vehicle", car, 4.0, 1.0)),
        ("person, 1.4 m/s, turns of 15-60 degrees/s, 3 m every second", turns("person", walk, 3.0, 1.0)),
    ]


def main() -> None:
    """Print all tables."""
    known = flights(Path(sys.argv[1]) if len(sys.argv) > 1 else fetch_collection())
    train, test = [f for f in known if not held_out(f)], [f for f in known if held_out(f)]
    print(f"{len(train)} flights to fit the rivals, {len(test)} held out; errors in metres")
    race("ADS-B as received (true is what is received next)", "aircraft", ads_b(train), ads_b(test))
    for name in RADARS:
        seen = radar(test, name, 2)
        race(name, "aircraft", radar(train, name, 1), seen)
        print(manoeuvring(seen))
    for title, scenario in targets():
        race(title, scenario.kind, simulated(scenario, range(60)), simulated(scenario, range(60, 260)))


if __name__ == "__main__":
    main()
