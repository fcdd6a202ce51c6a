"""Random families of targets and sensors that a correction in the plane is learned on."""

from __future__ import annotations

import numpy as np

from ..frozen import frozen
from ..models.plane_corrector import PlaneCorrector
from ..models.sensor import Position
from ..scenarios.random import RandomAccelerations, RandomTurns
from ..scenarios.scenario import Scenario
from ..scenarios.sensing import Observation, Schedule
from .plane_inputs import PLAIN, Weighing

RATIO = (0.05, 5.0)  # a T²/σ
SCANS, RUNS = 140, 8  # of a family
STRAIGHT = 1e9  # s: nobody manoeuvres


@frozen(kw_only=True)
class Spread:
    """How the targets and the sensors of a kind differ: ranges, drawn evenly in the logarithm.

    hardest (m/s²): the acceleration of the kind; pull: the hardest of a family over it; interval (s) between scans; sd
    (m) of positions, within which a T²/σ is held; speed (m/s); quiet and busy (s): mean lengths of legs; noise: process
    noise over the hardest acceleration. straight: share of families that never manoeuvre. usual: share of families near
    the middle. harder: share of families that are those of fighters, for which the kind's filter is not made.
    weighing: what squares of errors count. fade: as of ``PlaneCorrector``.
    """

    hardest: float
    pull: tuple[float, float]
    interval: tuple[float, float]
    sd: tuple[float, float]
    speed: tuple[float, float]
    quiet: tuple[float, float]
    busy: tuple[float, float]
    noise: tuple[float, float]
    straight: float
    usual: float
    harder: float = 0.0
    weighing: Weighing = PLAIN
    fade: float = PlaneCorrector.fade


SPREADS = {
    "fighter": Spread(
        hardest=100.0,
        pull=(0.08, 1.2),
        interval=(0.5, 10.0),
        sd=(5.0, 1500.0),
        speed=(80.0, 550.0),
        quiet=(15.0, 120.0),
        busy=(6.0, 30.0),
        noise=(0.004, 0.1),
        straight=0.1,
        usual=0.5,
        fade=0.1,
    ),
    "aircraft": Spread(
        hardest=3.0,
        pull=(0.1, 1.5),
        interval=(0.8, 13.0),
        sd=(4.0, 500.0),
        speed=(60.0, 270.0),
        quiet=(40.0, 600.0),
        busy=(10.0, 60.0),
        noise=(0.003, 0.1),
        straight=0.2,
        usual=0.0,
        harder=0.45,
        weighing=Weighing(turning=0.5, cap=5.0),
        fade=0.1,
    ),
}


def family(kind: str, rng: np.random.Generator) -> Scenario:
    """One family: targets that draw accelerations or turns, and a sensor."""
    s = SPREADS[kind]
    if s.harder and rng.uniform() < s.harder:
        s = SPREADS["fighter"]
    if rng.uniform() < s.usual:
        return _usual(s.hardest, kind, rng)

    def drawn(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    pull, interval, ratio = s.hardest * drawn(*s.pull), drawn(*s.interval), drawn(*RATIO)
    sd = float(np.clip(pull * interval**2 / ratio, *s.sd))
    quiet, busy, noise, speed = drawn(*s.quiet), drawn(*s.busy), pull * drawn(*s.noise), drawn(*s.speed)
    which = rng.uniform()
    quiet = STRAIGHT if which < s.straight else quiet
    seconds = int(np.ceil(SCANS * interval)) + 2
    if which > 0.5 * (1.0 + s.straight):
        truth = RandomAccelerations(
            quiet_mean=quiet, manoeuvre_mean=busy, acceleration=pull, noise_sd=noise, duration=seconds, headings=True
        )
        return _seen(truth, sd, interval, kind)
    fastest = min(pull / speed, 0.35)
    return _seen(_turns(speed, quiet, busy, fastest / 6, fastest, noise, seconds), sd, interval, kind)


def _usual(hardest: float, kind: str, rng: np.random.Generator) -> Scenario:
    """Scans every second or so of a sensor as in the published scenarios: within a factor of two of those families."""

    def about(value: float, factor: float = 1.4) -> float:
        return value * factor ** float(rng.uniform(-1.0, 1.0))

    interval, quiet, busy, noise = about(1.0, 1.25), about(40.0), about(15.0), about(0.01) * hardest
    seconds = int(np.ceil(SCANS * interval)) + 2
    if rng.uniform() < 0.5:
        pull = about(hardest)
        truth = RandomAccelerations(
            quiet_mean=quiet, manoeuvre_mean=busy, acceleration=pull, noise_sd=noise, duration=seconds, headings=True
        )
        return _seen(truth, about(5.0 * hardest), interval, kind)
    turns = _turns(about(2.5 * hardest), quiet, busy, np.radians(1.0), np.radians(about(6.0)), noise, seconds)
    return _seen(turns, about(0.5 * hardest), interval, kind)


def _turns(
    speed: float, quiet: float, busy: float, slowest: float, fastest: float, noise: float, seconds: int
) -> RandomTurns:
    return RandomTurns(
        speed=speed,
        straight_mean=quiet,
        turn_mean=busy,
        slowest=float(slowest),
        fastest=float(fastest),
        noise_sd=noise,
        duration=seconds,
    )


def _seen(truth: RandomAccelerations | RandomTurns, sd: float, interval: float, kind: str) -> Scenario:
    return Scenario(
        name="random family",
        summary="",
        truth=truth,
        observation=Observation(sensor=Position(sd=sd, axes=2)),
        schedule=Schedule(start=1.0, interval=interval, count=SCANS),
        kind=kind,
    )
