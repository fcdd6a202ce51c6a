"""Families of vessels and drones: smooth changes of course, speed and height, random in every run."""

from __future__ import annotations

import numpy as np

from ..checks import Array
from ..frozen import frozen
from ..metrics.draws import Draws
from ..models.sensor import Position
from .curves import Curves, Ramps, pulses
from .scenario import Scenario
from .sensing import Observation, Schedule

Range = tuple[float, float]


@frozen(kw_only=True)
class Vessel:
    """Course changes of 10–120° at a random turn rate, now and then another speed; an hour.

    speed (m/s), turn_rate (degrees/s), leg (s between turns) are uniform between the two figures, one draw
    per manoeuvre.
    """

    speed: Range = (2.0, 11.0)
    turn_rate: Range = (0.1, 0.8)
    leg: Range = (60.0, 600.0)
    duration: float = 3600.0

    def __call__(self, draws: Draws) -> Curves:
        turns, speeds = 10, 5
        angle = draws.sign(turns) * np.radians(draws.uniform(10.0, 120.0, turns))
        length = np.abs(angle) / np.radians(draws.uniform(*self.turn_rate, turns)) + 15.0
        begin, end = in_sequence(draws.uniform(*self.leg, turns), length)
        edge = 15.0
        course = pulses(draws.uniform(0.0, 2 * np.pi), begin, end, edge, edge, angle)
        speed = _levels(draws.uniform(*self.speed, speeds + 1), *_times(draws, speeds, (300.0, 900.0), (60.0, 300.0)))
        return Curves(np.zeros((len(draws), 2)), course, speed, None, self.duration, panel=30.0)


@frozen(kw_only=True)
class Drone:
    """A multicopter: legs at other speeds, hovering in between, quick turns, climbs; three minutes.

    speed (m/s; every third leg hovers), turn_rate (degrees/s), climb_rate (m/s) are uniform between the two
    figures.
    """

    speed: Range = (3.0, 18.0)
    turn_rate: Range = (15.0, 60.0)
    climb_rate: Range = (1.0, 3.0)
    duration: float = 180.0

    def __call__(self, draws: Draws) -> Curves:
        turns, speeds, climbs = 14, 12, 8
        angle = draws.sign(turns) * np.radians(draws.uniform(20.0, 180.0, turns))
        length = np.abs(angle) / np.radians(draws.uniform(*self.turn_rate, turns)) + 1.0
        begin, end = in_sequence(draws.uniform(4.0, 14.0, turns), length)
        course = pulses(draws.uniform(0.0, 2 * np.pi), begin, end, 1.0, 1.0, angle)
        levels = draws.uniform(*self.speed, speeds + 1) * (np.arange(speeds + 1) % 3 != 0)
        speed = _levels(levels, *_times(draws, speeds, (5.0, 12.0), (5.0, 9.0)))
        rates = np.zeros((len(draws), 2 * climbs + 1))
        rates[:, 1::2] = draws.uniform(*self.climb_rate, climbs) * np.where(np.arange(climbs) % 2, -1.0, 1.0)
        climb = _levels(rates, *_times(draws, 2 * climbs, (4.0, 9.0), (2.0, 3.0)))
        position = np.concatenate([draws.uniform(-300.0, 300.0, 2), draws.uniform(80.0, 150.0, 1)], axis=1)
        return Curves(position, course, speed, climb, self.duration, panel=1.0)


def in_sequence(gaps: Array, lengths: Array) -> tuple[Array, Array]:
    """Begin and end (B, P) of manoeuvres of given lengths with given gaps before each."""
    end = np.cumsum(gaps + lengths, axis=1)
    return end - lengths, end


def _times(draws: Draws, count: int, gap: Range, length: Range) -> tuple[Array, Array]:
    return in_sequence(draws.uniform(*gap, count), draws.uniform(*length, count))


def _levels(levels: Array, begin: Array, end: Array) -> Ramps:
    """From one level (B, P + 1) to the next between begin and end (B, P); onset and exit a quarter each."""
    edge = 0.25 * (end - begin)
    return pulses(levels[:, 0], begin, end, edge, edge, np.diff(levels, axis=1))


def vehicles() -> list[Scenario]:
    """vessel and drone."""
    return [
        Scenario(
            name="vessel",
            summary="a ship that alters course and speed, reported about every 10 s",
            truth=Vessel(),
            observation=Observation(sensor=Position(sd=10.0)),
            schedule=Schedule(start=5.0, interval=10.0, count=360, jitter=2.0),
            kind="vessel",
        ),
        Scenario(
            name="drone",
            summary="a multicopter that hovers, turns and climbs, seen twice a second",
            truth=Drone(),
            observation=Observation(sensor=Position(sd=2.0, axes=3)),
            schedule=Schedule(start=0.5, interval=0.5, count=360),
            axes=3,
            kind="drone",
        ),
    ]
