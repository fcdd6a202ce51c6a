"""The six aircraft of the radar benchmark, rebuilt as smooth curves that hit every manoeuvre of its table.

Blair, Watson, Kirubarajan & Bar-Shalom, Benchmark for Radar Allocation and Tracking in ECM, IEEE Trans.
AES-34(4), 1998.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import radians

import numpy as np

from ..frozen import frozen
from ..metrics.draws import Draws
from ..models.sensor import Position
from .curves import Curves, Ramps
from .scenario import Scenario
from .sensing import Observation, Schedule

G = 9.80665
DURATION = 185.0
SOURCE = "Blair et al., Benchmark for Radar Allocation and Tracking in ECM, IEEE Trans. AES-34(4), 1998"


@frozen
class Turn:
    """Begin and end (s), course change (degrees, to the right) and the listed lateral acceleration (g)."""

    begin: float
    end: float
    course: float
    g: float


@frozen
class Change:
    """A quantity changes between begin and end (s): its rate rises over onset and falls over exit (s)."""

    begin: float
    end: float
    change: float
    onset: float = 2.0
    exit: float = 2.0

    def ramps(self) -> list[tuple[float, float, float]]:
        """Begin, end and change of the rate."""
        rate = self.change / (self.end - self.begin - 0.5 * (self.onset + self.exit))
        return [(self.begin, self.begin + self.onset, rate), (self.end - self.exit, self.end, -rate)]


@frozen
class Braking:
    """The speed changes by `change` up to `end` and by `rest` up to `rested` (m/s, s): load (g) at first, then less.

    The rate reaches the load within onset, keeps it for a while, and falls in two lines, through `end`, to 0
    at `rested`.
    """

    begin: float
    end: float
    change: float
    load: float
    rested: float
    rest: float
    onset: float = 1.5

    def ramps(self) -> list[tuple[float, float, float]]:
        """Begin, end and change of the rate; the time it keeps the load follows from the change."""
        first, then = self.load * G, 2.0 * self.rest / (self.rested - self.end)
        fading = self.end - self.begin - self.onset
        kept = (self.change - 0.5 * first * self.onset - 0.5 * (first + then) * fading) / (0.5 * (first - then))
        fade = self.begin + self.onset + kept
        return [
            (self.begin, self.begin + self.onset, first),
            (fade, self.end, then - first),
            (self.end, self.rested, -then),
        ]


@frozen
class Height:
    """Climb by `change` (m) between begin and end (s); the vertical accelerations last `push` (s).

    peaked: the vertical acceleration rises to the middle, where the climb rate has its peak, and there
    changes sign.
    """

    begin: float
    end: float
    change: float
    push: float = 5.0
    peaked: float = 0.0

    def ramps(self) -> list[tuple[float, float, float]]:
        """Begin, end and change of the vertical acceleration."""
        if self.peaked:
            middle = 0.5 * (self.begin + self.end)
            halves = [
                Change(self.begin, middle, 1.0, self.peaked, 1.0),
                Change(middle, self.end, -1.0, 1.0, self.peaked),
            ]
        else:
            onset = 0.4 * self.push
            halves = [
                Change(self.begin, self.begin + self.push, 1.0, onset, onset),
                Change(self.end - self.push, self.end, -1.0, onset, onset),
            ]
        unit = [ramp for half in halves for ramp in half.ramps()]
        return [(b, e, c * self.change / _height(unit)) for b, e, c in unit]


def _height(ramps: list[tuple[float, float, float]]) -> float:
    begin, end, change = (np.array([column]) for column in zip(*ramps, strict=True))
    return float(Ramps(np.zeros(1), begin, end, change).integral(np.array([[DURATION]]))[0, 0])


@frozen
class Aircraft:
    """A line of the table: north, east, height (m), speed (m/s), course (degrees) at 0 s; manoeuvres."""

    what: str
    north: float
    east: float
    height: float
    speed: float
    course: float
    turns: tuple[Turn, ...]
    speeds: tuple[Change | Braking, ...] = ()
    heights: tuple[Height, ...] = ()


AIRCRAFT: dict[int, Aircraft] = {
    1: Aircraft(
        "cargo aircraft",
        72947.0,
        29474.0,
        1258.0,
        289.6,
        -153.4,
        (Turn(60, 80, 63, 1.72), Turn(110, 132, 109, 2.8)),
    ),
    2: Aircraft(
        "airliner",
        45705.0,
        -42864.0,
        4572.0,
        304.8,
        180.0,
        (Turn(30, 52, -90, 2.3), Turn(100, 114, 90, 3.7)),
        heights=(Height(55, 113, 3048.0 - 4572.0, push=10.4),),
    ),
    3: Aircraft(
        "bomber",
        60944.0,
        60944.0,
        3048.0,
        457.0,
        -135.0,
        (Turn(30, 41, 45, 3.9), Turn(75, 92, -90, 3.9)),
        speeds=(Braking(75, 92, 316.0 - 457.0, -1.1, 114, 274.0 - 316.0),),
    ),
    4: Aircraft(
        # 45° in 6 s leaves no room for ramps of a second at 3.8 g; 44.4° stay within 15% of it
        "bomber",
        30480.0,
        9130.0,
        2286.0,
        274.0,
        -90.0,
        (Turn(30, 36, -44.4, 3.8), Turn(70, 84, -136, 5.8)),
        speeds=(Change(70, 84, 255.0 - 274.0), Change(84, 141, 411.0 - 255.0)),
        heights=(Height(90, 141, 4570.0 - 2286.0),),
    ),
    5: Aircraft(
        "fighter",
        80950.0,
        970.0,
        1448.0,
        274.0,
        135.0,
        (Turn(30, 38, 44, 4.85), Turn(60, 72, -90, 6.85), Turn(117, 130, -85, 5.84)),
        speeds=(Change(0, 30, 398.0 - 274.0, 1.0, 1.0),),
        heights=(Height(131, 155, 4496.0 - 1448.0, peaked=2.5),),
    ),
    6: Aircraft(
        "fighter",
        65939.0,
        29384.0,
        1548.0,
        426.0,
        180.0,
        (Turn(30, 43, 90, 6.84), Turn(70, 85, -90, 5.5), Turn(115, 127, 144, 5.8), Turn(150, 157, -55, 6.83)),
        speeds=(
            Change(70, 85, 309.0 - 426.0),
            Change(85, 115, 253.0 - 309.0),
            Change(115, 127, 209.0 - 253.0),
            Change(127, 150, 350.0 - 209.0),
        ),
        heights=(Height(70, 85, 786.0 - 1548.0, push=6.0),),
    ),
}


@cache
def curve(number: int) -> Curves:
    """The path of one of the six aircraft; its speed is that along the path."""
    a = AIRCRAFT[number]
    speed = _ramps(a.speed, [ramp for change in a.speeds for ramp in change.ramps()])
    climb = _ramps(0.0, [ramp for change in a.heights for ramp in change.ramps()])
    course = _ramps(radians(a.course), [ramp for turn in a.turns for ramp in _turn(turn, speed)])
    start = np.array([[a.east, a.north, a.height]])
    return Curves(start, course, speed, climb, DURATION, along_path=True)


def _turn(turn: Turn, speed: Ramps) -> list[tuple[float, float, float]]:
    """Ramps of the turn rate: its onset and exit last 1–3 s, in between it keeps the lateral acceleration.

    The shape is g over speed, in a line from the end of the onset to the begin of the exit; scaled to the
    course change.
    """
    length = turn.end - turn.begin

    def shape(edge: float) -> tuple[float, float, float]:
        first, last = turn.begin + edge, turn.end - edge
        rates = [turn.g * G / float(speed(np.array([[t]]))[0][0, 0]) for t in (first, last)]
        return rates[0], rates[1], 0.5 * edge * sum(rates) + 0.5 * (length - 2 * edge) * sum(rates)

    wanted = radians(abs(turn.course))
    edges = np.linspace(1.0, min(3.0, 0.4 * length), 201)
    edge = min(edges, key=lambda each: abs(shape(each)[2] - wanted))
    one, two, total = shape(edge)
    one, two = (radians(turn.course) / total * rate for rate in (one, two))
    b, e = turn.begin, turn.end
    return [(b, b + edge, one), (b + edge, e - edge, two - one), (e - edge, e, -two)]


def _ramps(start: float, ramps: list[tuple[float, float, float]]) -> Ramps:
    begin, end, change = (np.array([[ramp[k] for ramp in ramps]]) for k in range(3))
    return Ramps(np.array([start]), begin, end, change)


def _truth(number: int) -> Callable[[Draws], Curves]:
    return lambda draws: curve(number)


def benchmark() -> list[Scenario]:
    """benchmark-1 … benchmark-6: the radar is the origin; by default positions of 50 m once a second."""
    return [
        Scenario(
            name=f"benchmark-{number}",
            summary=f"{aircraft.what}, turns of up to {max(turn.g for turn in aircraft.turns):g} g",
            truth=_truth(number),
            observation=Observation(sensor=Position(sd=50.0, axes=3)),
            schedule=Schedule(start=0.0, interval=1.0, count=186),
            axes=3,
            kind="fighter",
            source=SOURCE,
        )
        for number, aircraft in AIRCRAFT.items()
    ]
