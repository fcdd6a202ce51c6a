"""The scenarios of the five papers, in metres and seconds; scan k is at time k, the start state at time 0."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import pi, sqrt

import numpy as np

from ..metrics.draws import Draws
from ..models.sensor import Position
from .legs import Legs
from .scenario import Scenario
from .sensing import Observation, Schedule

LEE = "Lee, Joo & Park, A GA-Based IMM Method for Tracking a Maneuvering Target, Trans. KIEE 52D-1-3, 2003"
WANG = "Wang et al., A Fuzzy Adaptive Algorithm Based on 'Current' Statistical Model, Def. Technology 2010-3"
CHOI = "Choi, Samal & Ahn, On Neural-Net Based Variable Structure Multiple Model Method: Neural-Net Design, 2001"

# choi-2001: (start, velocity) of lines, (radius, rate) of circles, which the runs take in turn
LINES = [((0.0, 0.0), (x, y)) for x in (200.0, -200.0) for y in (100.0, -100.0)]
CIRCLES = [(radius, pi / 10) for radius in (50.0, 100.0, 150.0, 200.0)]


def lee_2003(draws: Draws) -> Legs:
    """x +10 m/s² over scans 40–60, y +60 over 80–90, x −30 over 120–140, inclusive; noise of 1 m/s².

    Scan k's input acts until scan k + 1. The noise acts through G = [T²/2, T]: constant between scans.
    """
    command = np.zeros((1, 180, 2))
    command[0, 40:61, 0], command[0, 80:91, 1], command[0, 120:141, 0] = 10.0, 60.0, -30.0
    start, side = np.arange(180.0)[None, :], sqrt(0.5)
    position, velocity = np.full((1, 2), 22400.0 * side), np.full((1, 2), 15.0 * side)
    return Legs(start, position, velocity, command, noise=draws.normal(180, 2))


def wang_velocity(draws: Draws) -> Legs:
    """One axis: 30, 20, 10 and 5 m/s² for 50 s each, from 10 km at 100 m/s."""
    command = np.array([30.0, 20.0, 10.0, 5.0]).reshape(1, 4, 1)
    return Legs(np.array([[0.0, 50.0, 100.0, 150.0]]), np.array([[10e3]]), np.array([[100.0]]), command)


def wang_circle(draws: Draws) -> Legs:
    """From (10 km, 0) at (150, 0) m/s for 30 s, then a circle of radius 10 km to the left until 150 s."""
    rate = np.array([[0.0, 150.0 / 10e3]])
    start = np.array([[10e3, 0.0]]), np.array([[150.0, 0.0]])
    return Legs(np.array([[0.0, 30.0]]), *start, np.zeros((1, 2, 2)), turn_rate=rate)


def wang_step(draws: Draws) -> Legs:
    """One axis: 0, then 60 m/s² from scan 50 to scan 100, then 0; from 10 km at 100 m/s."""
    command = np.array([0.0, 60.0, 0.0]).reshape(1, 3, 1)
    return Legs(np.array([[0.0, 50.0, 100.0]]), np.array([[10e3]]), np.array([[100.0]]), command)


def line(start: Sequence[float], velocity: Sequence[float]) -> Legs:
    """A straight line at constant velocity."""
    return Legs(np.zeros((1, 1)), np.array([start]), np.array([velocity]), np.zeros((1, 1, 2)))


def circle(radius: float, rate: float) -> Legs:
    """radius · (cos ωt, sin ωt)."""
    start, velocity = np.array([[radius, 0.0]]), np.array([[0.0, radius * rate]])
    return Legs(np.zeros((1, 1)), start, velocity, np.zeros((1, 1, 2)), turn_rate=np.array([[rate]]))


def choi_circle_line() -> Legs:
    """Circle π/5 rad/s of radius 225 m up to scan 10, from there a line at (200, 10) m/s: a jump."""
    radius, rate = 225.0, pi / 5
    step = np.zeros((1, 2, 2))
    step[0, 1] = np.array([200.0, 10.0]) - radius * rate * np.array([-np.sin(10 * rate), np.cos(10 * rate)])
    return Legs(
        np.array([[0.0, 10.0]]),
        np.array([[radius, 0.0]]),
        np.array([[0.0, radius * rate]]),
        np.zeros((1, 2, 2)),
        turn_rate=np.array([[rate, 0.0]]),
        velocity_step=step,
    )


def choi_bursts() -> Legs:
    """From (10, 10) at (200, 0) m/s; (20, −75) m/s² in scans 4–6 and 17–18, (−20, 75) in 11–13."""
    command = np.zeros((1, 20, 2))
    command[0, [4, 5, 6, 17, 18]], command[0, 11:14] = (20.0, -75.0), (-20.0, 75.0)
    return Legs(np.arange(20.0)[None, :], np.array([[10.0, 10.0]]), np.array([[200.0, 0.0]]), command)


def in_turn(paths: Sequence[Legs]) -> Callable[[Draws], Legs]:
    """Run r takes path r modulo their number; all of one leg each."""

    def truth(draws: Draws) -> Legs:
        which = draws.runs % len(paths)
        rates = [path.turn_rate if path.turn_rate is not None else np.zeros((1, 1)) for path in paths]
        p, v = (np.concatenate([getattr(path.at(np.zeros((1, 1))), name)[:, 0] for path in paths]) for name in STATE)
        return Legs(np.zeros((1, 1)), p[which], v[which], np.zeros((1, 1, 2)), turn_rate=np.concatenate(rates)[which])

    return truth


STATE = ("position", "velocity")


def _scenario(
    name: str,
    summary: str,
    truth: Callable[[Draws], Legs],
    sd: float,
    scans: int,
    source: str,
    axes: int = 2,
    acceleration: float | None = None,
) -> Scenario:
    seen = Observation(sensor=Position(sd=sd, axes=axes))
    schedule = Schedule(start=1.0, interval=1.0, count=scans)
    return Scenario(
        name=name,
        summary=summary,
        truth=truth,
        observation=seen,
        schedule=schedule,
        axes=axes,
        kind="fighter",
        source=source,
        acceleration=acceleration,
    )


def _fixed(path: Legs) -> Callable[[Draws], Legs]:
    return lambda draws: path


def lee_and_wang() -> list[Scenario]:
    """lee-2003 and the experiments of wang-2010 (noise of 50 m, which the paper does not state)."""
    summary = "three constant accelerations along the axes"
    return [
        # §4: the largest input is assumed to be 0.1 km/s²
        _scenario("lee-2003", summary, lee_2003, 500.0, 180, LEE, acceleration=100.0),
        _scenario("wang-2010-velocity", "one axis, 30, 20, 10, 5 m/s²", wang_velocity, 50.0, 200, WANG, axes=1),
        _scenario("wang-2010-circle", "straight, then a circle of 10 km radius", wang_circle, 50.0, 150, WANG),
        _scenario("wang-2010-step", "one axis, 0 to 60 to 0 m/s²", wang_step, 50.0, 150, WANG, axes=1),
    ]


def choi() -> list[Scenario]:
    """Test scenarios 1–4 and the three training sets of choi-2001: noise of 1 m, 20 scans."""
    mixed = [line((0.0, 0.0), v) for v in ((200.0, 100.0), (-200.0, -100.0))] + [
        circle(r, pi / 10) for r in (50.0, 100.0)
    ]
    paths: dict[str, tuple[str, Callable[[Draws], Legs]]] = {
        "1": ("a straight line", _fixed(line((10.0, 10.0), (200.0, 10.0)))),
        "2": ("a circle of 225 m at 18°/s", _fixed(circle(225.0, pi / 10))),
        "3": ("a circle at 36°/s, then a line", _fixed(choi_circle_line())),
        "4": ("three bursts of 7.9 g", _fixed(choi_bursts())),
        "line": (
            "training: four lines, run r takes line r modulo 4",
            in_turn([line(*each) for each in LINES]),
        ),
        "circle": (
            "training: circles of 50, 100, 150, 200 m in turn",
            in_turn([circle(*each) for each in CIRCLES]),
        ),
        "mixed": ("training: two lines and two circles in turn", in_turn(mixed)),
    }
    return [_scenario(f"choi-2001-{key}", text, truth, 1.0, 20, CHOI) for key, (text, truth) in paths.items()]
