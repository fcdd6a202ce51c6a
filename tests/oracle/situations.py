"""Compositions and data on which the native filters are compared with the oracle."""

from __future__ import annotations

import numpy as np

from oracle.twin import Data, Twin, part

CV = part("ConstantVelocity", acceleration_sd=0.5)
BRISK = part("ConstantVelocity", acceleration_psd=[40.0, 90.0])
CA = part("ConstantAcceleration", jerk_psd=0.3, acceleration_prior_sd=8.0)
CA_STEPS = part("ConstantAcceleration", acceleration_increment_sd=0.8)
SINGER = part("Singer", acceleration_sd=5.0, time_constant=15.0)
CT = part("CoordinatedTurn", acceleration_sd=0.4, turn_rate_sd=0.004, turn_rate_prior_sd=0.05)
CT_PSD = part("CoordinatedTurn", acceleration_psd=0.4, turn_rate_psd=2e-5)
LEFT = part("KnownTurn", turn_rate=0.06, acceleration_sd=0.5)
RIGHT = part("KnownTurn", turn_rate=-0.06, acceleration_psd=0.5)

P1, P2, P3 = (part("Position", sd=25.0, axes=n) for n in (1, 2, 3))
PV2 = part("PositionVelocity", sd=25.0, velocity_sd=3.0, axes=2)
CORRELATED = part("Position", covariance=[[900.0, 300.0], [300.0, 400.0]], axes=2)
RADAR = part("Polar", range_sd=20.0, azimuth_sd=0.003, site=(-3000.0, -20000.0))
DOPPLER = part("Polar", range_sd=20.0, azimuth_sd=0.003, range_rate_sd=1.5, site=(4000.0, -15000.0))
RADAR3 = part("Polar", range_sd=20.0, azimuth_sd=0.003, elevation_sd=0.004, site=(-3000.0, -20000.0, 100.0))
HEIGHT = part("Polar", range_sd=20.0, azimuth_sd=0.003, height_sd=30.0, site=(-3000.0, -20000.0, 0.0))
FULL3 = part("Polar", range_sd=20.0, azimuth_sd=0.003, elevation_sd=0.004, range_rate_sd=1.5, site=(0.0, -20000.0, 0.0))
CONVERTED = part("Polar", range_sd=20.0, azimuth_sd=0.003, site=(-3000.0, -20000.0), method="converted")
CONVERTED3 = part(
    "Polar",
    range_sd=20.0,
    azimuth_sd=0.003,
    elevation_sd=0.004,
    site=(0.0, -20000.0, 0.0),
    method="converted",
)
COMPASS = part("Bearing", sd=0.01, site=(500.0, -9000.0))

TWO = part("TwoPoint", velocity_sd=300.0)
BOUNDED = part("TwoPoint", velocity_sd=200.0, bounded=True)
SLOW = part("TwoPoint", velocity_sd=8.0, bounded=True)  # of targets that are faster than they should be
ONE = part("OnePoint", velocity_sd=300.0)
ROBUST = {"share": 0.01, "extent": 1e5, "restart_after": 2}
SOJOURN = {"seconds": [60.0, 20.0, 15.0]}
LEADING = [[0.9, 0.06, 0.04], [0.1, 0.85, 0.05], [0.2, 0.05, 0.75]]

SITUATIONS: dict[str, Twin] = {
    "kalman-cv-1": Twin([CV], [P1], 1, initial=TWO),
    "kalman-cv-3": Twin([CV], [P3], 3, initial=ONE),
    "kalman-cv-correlated": Twin([BRISK], [CORRELATED], 2, initial=TWO),
    "kalman-ca-1": Twin([CA], [P1], 1, initial=TWO),
    "kalman-ca-steps-3": Twin([CA_STEPS], [P3], 3, initial=TWO),
    "kalman-singer-2": Twin([SINGER], [P2], 2, initial=TWO),
    "kalman-ct-2": Twin([CT], [P2], 2, initial=TWO),
    "kalman-ct-3": Twin([CT_PSD], [P3], 3, initial=ONE),
    "kalman-left": Twin([LEFT], [P2], 2, initial=ONE),
    "kalman-velocity": Twin([CV], [PV2], 2, initial=ONE),
    "kalman-radar": Twin([CV], [RADAR], 2, initial=TWO),
    "kalman-doppler": Twin([CA], [DOPPLER], 2, initial=ONE),
    "kalman-radar-3": Twin([CV], [RADAR3], 3, initial=TWO),
    "kalman-height": Twin([CV], [HEIGHT], 3, initial=TWO),
    "kalman-full-3": Twin([CT], [FULL3], 3, initial=ONE),
    "kalman-converted": Twin([CV], [CONVERTED], 2, initial=TWO),
    "kalman-converted-3": Twin([CA], [CONVERTED3], 3, initial=ONE),
    "kalman-robust": Twin([CV], [P2], 2, outliers=ROBUST, initial=TWO),
    "kalman-ukf-ct": Twin([CT], [RADAR], 2, linearisation="ukf", initial=ONE),
    "kalman-ukf-3": Twin([CA], [FULL3], 3, linearisation="ukf", initial=ONE),
    "kalman-sensors": Twin([CV], [P2, RADAR, COMPASS], 2, initial=ONE),
    "imm-2cv-1": Twin([CV, CA_STEPS], [P1], 1, 0.95, initial=TWO),
    "imm-3cv": Twin([CV, BRISK, part("ConstantVelocity", acceleration_sd=9.0)], [P2], 2, LEADING, initial=TWO),
    "imm-mixed": Twin([CV, CA, CT], [P2], 2, LEADING, initial=TWO),
    "imm-mixed-3": Twin([CV, CA, CT], [P3], 3, LEADING, initial=ONE, mode_probability=[0.6, 0.3, 0.1]),
    "imm-unbiased": Twin([CV, CA, CT], [P2], 2, LEADING, mixing="unbiased", initial=TWO),
    "imm-sojourn": Twin([CV, CA, CT], [P2], 2, SOJOURN, initial=TWO),
    "imm-sojourn-to": Twin(
        [CV, CA, CT], [P2], 2, {"seconds": [50.0, 9.0, 12.0], "to": [[0, 0.7, 0.3], [1, 0, 0], [0.5, 0.5, 0]]}
    ),
    "imm-step": Twin([CV, CA], [P2], 2, 0.97, transition_step=2.0, initial=TWO),
    "imm-robust": Twin([CV, CA, CT], [P2], 2, LEADING, outliers=ROBUST, initial=TWO),
    "kalman-bounded": Twin([CA], [P3], 3, initial=BOUNDED),
    "imm-bounded": Twin([CV, CA, CT], [CORRELATED], 2, LEADING, outliers=ROBUST, initial=BOUNDED),
    "imm-bounded-radar": Twin([CV, CT], [RADAR], 2, 0.95, initial=SLOW),
    "imm-bounded-slow": Twin([CV, CA, CT], [P2], 2, LEADING, outliers=ROBUST, initial=SLOW),
    "imm-turns": Twin([CV, LEFT, RIGHT], [P2], 2, LEADING, initial=TWO),
    "imm-turns-and-ca": Twin([LEFT, CA, CT], [P2], 2, LEADING, initial=ONE),
    "imm-singer": Twin([CV, SINGER], [P2], 2, 0.9, initial=TWO),
    "imm-radar": Twin([CV, CT], [RADAR], 2, SOJOURN | {"seconds": [60.0, 20.0]}, initial=TWO),
    "imm-doppler-robust": Twin([CV, CA, CT], [DOPPLER], 2, LEADING, outliers=ROBUST, initial=TWO),
    "imm-sensors": Twin([CV, CA, CT], [P2, DOPPLER, COMPASS], 2, LEADING, outliers=ROBUST, initial=ONE),
    "imm-converted": Twin([CV, CT], [CONVERTED], 2, 0.95, initial=TWO),
    "imm-ukf": Twin([CV, CT], [RADAR], 2, 0.95, linearisation="ukf", initial=TWO),
    "imm-ukf-mixed-3": Twin([CV, CA, CT], [RADAR3], 3, LEADING, linearisation="ukf", initial=TWO),
}


def flight(time: np.ndarray, axes: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities of something that flies straight, turns at up to 4 deg/s and climbs, at any
    times.
    """
    fine = np.arange(time[0], time[-1] + 0.05, 0.05)
    legs = np.searchsorted(np.cumsum(rng.exponential(15.0, 200)), fine - fine[0])
    rate = np.where(np.arange(201) % 2, rng.uniform(-0.07, 0.07, 201), 0.0)[legs]
    course = rng.uniform(0, 2 * np.pi) + np.cumsum(rate) * 0.05
    speed = 180.0 + 30.0 * np.sin(fine / 40.0)
    velocity = np.c_[speed * np.cos(course), speed * np.sin(course), 5.0 * np.sin(fine / 20.0)][:, :axes]
    position = np.cumsum(velocity, axis=0) * 0.05 + np.array([1000.0, 2000.0, 3000.0])[:axes]
    return sampled(time, fine, position), sampled(time, fine, velocity)


def sampled(time: np.ndarray, fine: np.ndarray, values: np.ndarray) -> np.ndarray:
    return np.stack([np.interp(time, fine, column) for column in values.T], axis=1)


def times(N: int, rng: np.random.Generator, same: float) -> np.ndarray:
    """Irregular times; a share `same` of the rows come at the same instant as the row before."""
    dt = rng.lognormal(np.log(2.0), 0.5, N)
    dt[rng.random(N) < same] = 0.0
    dt[0] = 5.0
    return np.cumsum(dt)


def make_data(
    twin: Twin, N: int = 60, seed: int = 0, missing: float = 0.1, partial: float = 0.05, same: float = 0.05
) -> Data:
    """A flight seen by the twin's sensors: irregular, with misses, in turn from each sensor, with outliers if
    robust.
    """
    rng = np.random.default_rng([seed, len(twin.motions), twin.axes])
    time = times(N, rng, same)
    position, velocity = flight(time, twin.axes, rng)
    sensors = [p.sensor() for p in twin.sensors]
    which = rng.integers(0, len(sensors), N) if len(sensors) > 1 else np.zeros(N, int)
    which[:2] = 0
    z = np.full((N, max(s.m for s in sensors)), np.nan)
    for k in range(N):
        s = sensors[which[k]]
        h = s.h(position[k], velocity[k])
        z[k, : s.m] = h + np.linalg.cholesky(s.R) @ rng.normal(size=s.m)
        for i in s.angles:
            z[k, i] = (z[k, i] + np.pi) % (2 * np.pi) - np.pi
    z[2:][rng.random(N - 2) < missing] = np.nan
    if not any(getattr(s, "method", "ekf") == "converted" for s in sensors):
        z[2:][rng.random((N - 2, z.shape[1])) < partial] = np.nan
    if twin.outliers is not None:
        z[N // 3, 0] += 5e4
        z[2 * N // 3 :, 0] += 5e4
    return Data(time, z, which if len(sensors) > 1 else None)
