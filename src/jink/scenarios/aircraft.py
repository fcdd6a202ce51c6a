"""Families of aircraft: a fighter that weaves, airliners that leave and reach an airport."""

from __future__ import annotations

import numpy as np

from ..checks import Array
from ..frozen import frozen
from ..metrics.draws import Draws
from ..models.sensor import Polar, Position
from .curves import Curves, Ramps, pulses
from .scenario import Scenario
from .sensing import Observation, Schedule
from .truth import Kinematics

G = 9.80665


@frozen(kw_only=True)
class Weave:
    """Straight, then 4–10 turns to one side and the other, then straight again; in the plane.

    speed (m/s), half_period (s) and lateral acceleration load (g) are uniform between the two figures, one
    draw per run; turns begin and end as clothoids over a sixth of the half period.
    """

    speed: tuple[float, float] = (150.0, 350.0)
    half_period: tuple[float, float] = (6.0, 15.0)
    load: tuple[float, float] = (1.0, 5.0)
    quiet: tuple[float, float] = (15.0, 45.0)
    duration: float = 180.0

    def __call__(self, draws: Draws) -> Curves:
        speed, half, load, first = (
            draws.uniform(*limits) for limits in (self.speed, self.half_period, self.load, self.quiet)
        )
        side, heading, count = (
            draws.sign(),
            draws.uniform(0.0, 2 * np.pi),
            draws.uniform(4.0, 11.0).astype(int),
        )
        turn = np.arange(10)[None, :]
        begin = first[:, None] + turn * half[:, None]
        angle = (load * G / speed * half * 5 / 6)[:, None] * (side[:, None] * np.where(turn % 2, -1.0, 1.0))
        angle = angle * np.where((turn == 0) | (turn == count[:, None] - 1), 0.5, 1.0) * (turn < count[:, None])
        edge = half[:, None] / 6
        course = pulses(heading, begin, begin + half[:, None], edge, edge, angle)
        still = np.zeros((len(draws), 0))
        return Curves(np.zeros((len(draws), 2)), course, Ramps(speed, still, still, still), None, self.duration)


@frozen
class EitherWay:
    """A curve, flown backwards in the runs where `backwards` (B,) is true."""

    curve: Curves
    backwards: np.ndarray

    @property
    def runs(self) -> int:
        """B"""
        return self.curve.runs

    def at(self, time: Array) -> Kinematics:
        """Kinematics at the times (B, n)."""
        there = self.curve.at(self._turned(time))
        sign = np.where(self.backwards, -1.0, 1.0)[:, None, None]
        return Kinematics(there.position, sign * there.velocity, there.acceleration)

    def breaks(self) -> Array:
        """(B, K) begin and end of all ramps."""
        return self._turned(self.curve.breaks())

    def _turned(self, time: Array) -> Array:
        return np.where(self.backwards[:, None], self.curve.duration - time, time)


@frozen(kw_only=True)
class TerminalArea:
    """Airliners: a departure or an arrival, each as likely, of 15 minutes, from or to a runway at the origin.

    Both are drawn outwards from the runway and arrivals then flown backwards: straight out (the final
    approach, on a 3° slope), turns of 15–120° at bank angles of `bank` (degrees), faster and higher by and
    by, level in between.
    """

    bank: tuple[float, float] = (12.0, 25.0)
    roll: float = 4.0
    duration: float = 900.0

    def __call__(self, draws: Draws) -> EitherWay:
        arrival = draws.uniform(0.0, 1.0) < 0.5
        speed = self._speed(draws, arrival)
        position = np.concatenate([draws.uniform(-500.0, 500.0, 2), np.full((len(draws), 1), 30.0)], axis=1)
        curve = Curves(
            position,
            self._course(draws, arrival, speed),
            speed,
            self._climb(draws, arrival),
            self.duration,
            panel=10.0,
        )
        return EitherWay(curve, arrival)

    def _speed(self, draws: Draws, arrival: np.ndarray) -> Ramps:
        """Departures 80, 125, 215 m/s; arrivals, outwards, 72, 115, 150, 215 m/s; each but the first ± 10."""
        levels = _choose(arrival, [72.0, 115.0, 150.0, 215.0], [80.0, 125.0, 125.0, 215.0])
        levels[:, 1:] += draws.uniform(-10.0, 10.0, 1)
        begin = _choose(arrival, [170.0, 340.0, 520.0], [10.0, 110.0, 150.0]) + draws.uniform(-10.0, 30.0, 1)
        length = _choose(arrival, [80.0, 60.0, 150.0], [80.0, 20.0, 300.0])
        return pulses(levels[:, 0], begin, begin + length, 0.2 * length, 0.2 * length, np.diff(levels, axis=1))

    def _climb(self, draws: Draws, arrival: np.ndarray) -> Ramps:
        """Departures 11, 8, 0 m/s; arrivals, outwards, 3.8 (3°), 0, 7, 0 m/s; the climbs ± 20%."""
        levels = _choose(arrival, [0.0, 3.8, 0.0, 7.0, 0.0], [0.0, 11.0, 8.0, 8.0, 0.0])
        levels[:, 2:] *= draws.uniform(0.8, 1.2, 1)
        begin = _choose(arrival, [0.0, 190.0, 300.0, 720.0], [5.0, 170.0, 300.0, 600.0]) + draws.uniform(0.0, 60.0, 1)
        begin[:, 0] = np.where(arrival, 0.0, 5.0)
        return pulses(levels[:, 0], begin, begin + 12.0, 4.0, 4.0, np.diff(levels, axis=1))

    def _course(self, draws: Draws, arrival: np.ndarray, speed: Ramps) -> Ramps:
        turns = 5
        angle = draws.sign(turns) * np.radians(draws.uniform(15.0, 120.0, turns))
        bank, gap = np.radians(draws.uniform(*self.bank, turns)), draws.uniform(20.0, 150.0, turns)
        begin, end = np.empty(angle.shape), np.empty(angle.shape)
        now = np.where(arrival, 200.0, 30.0) + draws.uniform(0.0, 60.0)
        for turn in range(turns):
            begin[:, turn] = now
            fastest = speed((now + 60.0)[:, None])[0][:, 0]
            end[:, turn] = now + np.abs(angle[:, turn]) * fastest / (G * np.tan(bank[:, turn])) + self.roll
            now = end[:, turn] + gap[:, turn]
        return pulses(draws.uniform(0.0, 2 * np.pi), begin, end, self.roll, self.roll, angle)


def _choose(which: np.ndarray, yes: list[float], no: list[float]) -> Array:
    return np.where(which[:, None], np.array(yes), np.array(no))


def flown() -> list[Scenario]:
    """weave and terminal-area."""
    radar = Polar(range_sd=50.0, azimuth_sd=1.4e-3, height_sd=8.0, site=(2000.0, 1000.0, 0.0))
    return [
        Scenario(
            name="weave",
            summary="a fighter that weaves with 1–5 g",
            truth=Weave(),
            observation=Observation(sensor=Position(sd=50.0)),
            schedule=Schedule(start=1.0, interval=1.0, count=180),
            kind="fighter",
        ),
        Scenario(
            name="terminal-area",
            summary="airliners that leave and reach an airport, seen by its radar every 4 s",
            truth=TerminalArea(),
            observation=Observation(sensor=radar),
            schedule=Schedule(start=1.0, interval=4.0, count=224, jitter=0.05),
            axes=3,
        ),
    ]
