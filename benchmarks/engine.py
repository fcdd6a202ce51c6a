"""jink's own jobs: the same cases the peers get, and those only jink can do."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

import jink

from .cases import ACCELERATION_SD, POSITION_SD, STAY, VELOCITY_PRIOR_SD, Case, irregular, polar, regular
from .race import Job

STATES = ("x", "log_likelihood")
EVERYTHING = ("x", "P", "mode_probability", "log_likelihood", "nis")
RANGE_SD = 50.0
AZIMUTH_SD = 2e-3


def kalman(case: Case, outputs: Sequence[str] = ("x",), threads: int = 1) -> Job:
    """Kalman filter, constant velocity, 4 states, every track with its own covariance."""
    motion = jink.ConstantVelocity(acceleration_sd=ACCELERATION_SD[0])
    return _batch(jink.Kalman(motion, jink.Position(sd=POSITION_SD)), case, case.z, outputs, threads, _prior(case))


def imm(case: Case, outputs: Sequence[str] = STATES, threads: int = 1) -> Job:
    """IMM of three constant-velocity modes."""
    return _batch(_imm(), case, case.z, outputs, threads, _prior(case))


def mixed(case: Case, outputs: Sequence[str] = STATES) -> Job:
    """IMM of two constant-velocity modes and one of constant acceleration: 4, 4 and 6 states."""
    quiet, loud, _ = ACCELERATION_SD
    motions = [
        jink.ConstantVelocity(acceleration_sd=quiet),
        jink.ConstantVelocity(acceleration_sd=loud),
        jink.ConstantAcceleration(jerk_psd=4.0),
    ]
    estimator = jink.IMM(motions, jink.Position(sd=POSITION_SD), STAY, initial=_two_point())
    return _batch(estimator, case, case.z, outputs, 1, None)


def turning(case: Case, outputs: Sequence[str] = STATES) -> Job:
    """IMM of constant velocity and coordinated turn, range and azimuth measured: an extended filter."""
    motions = [
        jink.ConstantVelocity(acceleration_sd=1.0),
        jink.CoordinatedTurn(acceleration_sd=2.0, turn_rate_sd=0.01),
    ]
    sensor = jink.Polar(range_sd=RANGE_SD, azimuth_sd=AZIMUTH_SD)
    estimator = jink.IMM(motions, sensor, STAY, initial=_two_point())
    return _batch(estimator, case, polar(case, RANGE_SD, AZIMUTH_SD), outputs, 1, None)


def live(case: Case) -> Job:
    """One IMM track; an update with a NumPy row, and its state read, per scan."""
    estimator = _imm()
    scans = list(zip(case.time.tolist(), case.z, strict=True))

    def prepare() -> Any:
        tracker = estimator.start()
        tracker.begin(case.x0[0], case.P0, scans[0][0])
        return tracker

    def run(tracker: Any) -> Any:
        update = tracker.update
        for t, z in scans:
            x = update(t, z).x
        return x

    return Job(run, case.updates, prepare)


def live_batch(case: Case) -> Job:
    """All tracks at once, scan by scan; the cost is of one scan of all of them."""
    estimator = _imm()
    times = case.time[: case.scans].tolist()
    z = np.ascontiguousarray(case.measurements().transpose(1, 0, 2))

    def run(tracker: Any) -> Any:
        for k, t in enumerate(times):
            x = tracker.update(t, z[k]).x
        return x

    return Job(run, case.scans, lambda: estimator.start(case.tracks))


def jobs(tracks: int, scans: int) -> dict[str, Job]:
    """Every job of the engine's race by name."""
    plain, holey, uneven = (
        regular(tracks, scans),
        irregular(tracks, scans),
        irregular(tracks, scans, missing=0.0),
    )
    return {
        "imm": imm(plain),
        "imm, every output": imm(plain, EVERYTHING),
        "mixed": mixed(holey),
        "mixed, every output": mixed(holey, EVERYTHING),
        "turning": turning(uneven),
        "kalman": kalman(plain),
        "live": live(regular(1, 10 * scans)),
        "live batch": live_batch(regular(tracks, min(scans, 30))),
    }


def _imm() -> Any:
    motions = [jink.ConstantVelocity(acceleration_sd=sd) for sd in ACCELERATION_SD]
    return jink.IMM(motions, jink.Position(sd=POSITION_SD), STAY, initial=_two_point())


def _prior(case: Case) -> Any:
    return jink.Prior(case.x0, case.P0)


def _two_point() -> Any:
    return jink.TwoPoint(velocity_sd=VELOCITY_PRIOR_SD)


def _batch(estimator: Any, case: Case, z: Any, outputs: Sequence[str], threads: int, initial: Any) -> Job:
    def run(_: None) -> Any:
        estimate = estimator.filter(
            case.time, z, offsets=case.offsets, initial=initial, threads=threads, outputs=tuple(outputs)
        )
        return estimate.x.reshape(case.tracks, case.scans, -1)

    return Job(run, case.updates)
