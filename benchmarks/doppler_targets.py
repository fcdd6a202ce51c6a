"""The simulated Doppler radar of the Optimized Kalman Filter (OKF), made anew from its description.

Greenberg, Yannay and Mannor, *Optimization or Architecture: How to Hack Kalman Filtering*, NeurIPS 2023; the settings
are those of their repository UsingKalmanFilterTheRightWay (ScenarioSimulator, TargetSimulator, SensorGenerator). The
random numbers are not theirs, so targets agree in distribution only. A target flies straight legs, at constant velocity
or accelerating, with turns between them; it is seen once a second.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

STEP = 1.0  # s
RANGE_SD, AZIMUTH_SD, ELEVATION_SD, RATE_SD = 10.0, np.deg2rad(1.0), np.deg2rad(3.0), 5.0
SPEED, SPEED_SD, CLIMB_SD, FASTEST = 70.0, 15.0, np.deg2rad(6.0), 150.0  # m/s, rad
SHORTEST = 5.0  # s, of a leg
TURN = np.deg2rad([45.0, 270.0])  # rad, least and most; a tenth of it in the vertical
VERTICAL, STEEPEST = 0.3, np.deg2rad(30.0)  # share of turns that are vertical; the path's angle at which they end


@dataclass(frozen=True)
class Setting:
    """One of the benchmark's data sets.

    acceleration (m/s²): the most; a leg or turn has half of it or more. leg, leg_sd (s): its duration. turns: least and
    most. box (m): half sides about the radar in which targets begin; where they are centred, sd of their middle.
    """

    acceleration: float
    leg: float
    leg_sd: float
    turns: tuple[int, int] = (0, 0)
    box: tuple[float, float, float] = (4000.0, 4000.0, 400.0)
    centred: bool = False


SETTINGS = {
    "close": Setting(0.0, 30.0, 8.0, box=(200.0, 200.0, 200.0), centred=True),
    "const-v": Setting(0.0, 30.0, 8.0),
    "const-a": Setting(16.0, 30.0, 8.0),
    "free": Setting(32.0, 10.0, 2.0, turns=(1, 3)),
}


@dataclass(frozen=True)
class Flights:
    """Targets laid end to end: time (N,) s, truth (N, 6) of positions (m) and velocities (m/s), z (N, 4) of range (m),
    azimuth and elevation (rad, azimuth clockwise from +y) and range rate (m/s); offsets (B + 1,)."""

    time: np.ndarray
    truth: np.ndarray
    z: np.ndarray
    offsets: np.ndarray

    def __len__(self) -> int:
        return len(self.offsets) - 1

    @property
    def positions(self) -> np.ndarray:
        """Where the plots lie, (N, 3)."""
        return to_positions(self.z)


def simulate(setting: Setting, targets: int, seed: int) -> Flights:
    """That many targets and their plots."""
    rng = np.random.default_rng(seed)
    paths = [path(setting, rng) for _ in range(targets)]
    truth = np.concatenate(paths)
    lengths = np.array([len(each) for each in paths])
    time = np.concatenate([STEP * np.arange(n) for n in lengths])
    noise = rng.standard_normal((len(truth), 4)) * [RANGE_SD, AZIMUTH_SD, ELEVATION_SD, RATE_SD]
    return Flights(time, truth, observed(truth) + noise, np.r_[0, np.cumsum(lengths)])


def path(setting: Setting, rng: np.random.Generator) -> np.ndarray:
    """Positions and velocities of one target (n, 6), a row a second."""
    begin, velocity = start(setting, rng)
    parts = [leg(velocity, setting, rng)]
    for _ in range(int(rng.integers(setting.turns[0], setting.turns[1] + 1))):
        parts.append(turn(parts[-1][-1], setting, rng)[1:])
        last = parts[-1][-1] if len(parts[-1]) else parts[-2][-1]
        parts.append(leg(last, setting, rng, after_turn=True)[1:])
    v = np.concatenate(parts)
    x = begin + np.r_[np.zeros((1, 3)), np.cumsum(0.5 * STEP * (v[1:] + v[:-1]), axis=0)]
    if setting.centred:
        x += begin - x.mean(axis=0)
    return np.concatenate([x, v], axis=1)


def start(setting: Setting, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Where a target begins, or its middle, and its first velocity: any heading, nearly level."""
    box = np.array(setting.box)
    begin = rng.normal(0.0, box) if setting.centred else rng.uniform(-box, box)
    speed, heading, climb = abs(rng.normal(SPEED, SPEED_SD)), rng.uniform(0.0, 2.0 * np.pi), rng.normal(0.0, CLIMB_SD)
    level = np.array([np.cos(heading), np.sin(heading)]) * np.cos(climb)
    return begin, speed * np.r_[level, np.sin(climb)]


def leg(velocity: np.ndarray, setting: Setting, rng: np.random.Generator, after_turn: bool = False) -> np.ndarray:
    """Velocities (n, 3) along a straight line; every second one gains speed, up to the fastest.

    The duration is log-normal. Its sd is the setting's, but equals the mean where a target keeps its velocity after a
    turn: so the benchmark's program has it.
    """
    gains = rng.random() < 0.5
    gain = pull(setting, rng) if gains else 0.0
    spread = setting.leg if after_turn and not gains else setting.leg_sd
    t = times(max(SHORTEST, lognormal(setting.leg, spread, rng)))
    speed = float(np.linalg.norm(velocity))
    speeds = np.minimum(speed + gain * t, FASTEST) if speed < FASTEST else np.full(len(t), speed)
    return speeds[:, None] * (velocity / speed)


def turn(velocity: np.ndarray, setting: Setting, rng: np.random.Generator) -> np.ndarray:
    """Velocities (n, 3) of constant speed that turn left or right, or up or down and then five times as gently."""
    vertical = rng.random() < VERTICAL
    a = pull(setting, rng) / (5.0 if vertical else 1.0)
    angle = rng.choice([-1.0, 1.0]) * rng.uniform(*TURN) * (0.1 if vertical else 1.0)
    speed = float(np.linalg.norm(velocity))
    t = times(abs(angle) * speed / a + 1.0)
    level = float(np.hypot(velocity[0], velocity[1]))
    heading, climb = np.arctan2(velocity[1], velocity[0]), np.arctan2(velocity[2], level)
    if vertical:
        up = np.sign(angle)
        # a path that is steeper already stays as it is
        last = max(STEEPEST, up * climb)
        climb = up * np.minimum(up * climb + a / speed * t, last)
        return speed * np.stack([np.cos(climb) * np.cos(heading), np.cos(climb) * np.sin(heading), np.sin(climb)], 1)
    heading = heading + np.sign(angle) * a / level * t
    return np.stack([level * np.cos(heading), level * np.sin(heading), np.full(len(t), velocity[2])], axis=1)


def pull(setting: Setting, rng: np.random.Generator) -> float:
    """An acceleration between half of the most and the most, m/s²."""
    return setting.acceleration * rng.uniform(0.5, 1.0)


def times(duration: float) -> np.ndarray:
    """Seconds from the beginning, to the last before the end."""
    return np.arange(0.0, duration, STEP)


def lognormal(mean: float, sd: float, rng: np.random.Generator) -> float:
    """A log-normal number of this mean and sd."""
    variance = np.log1p((sd / mean) ** 2)
    return float(rng.lognormal(np.log(mean) - 0.5 * variance, np.sqrt(variance)))


def observed(truth: np.ndarray) -> np.ndarray:
    """Range, azimuth, elevation and range rate without noise, (N, 4)."""
    x, v = truth[:, :3], truth[:, 3:]
    far = np.linalg.norm(x, axis=1)
    rate = (x * v).sum(axis=1) / far
    return np.stack([far, np.arctan2(x[:, 0], x[:, 1]), np.arcsin(x[:, 2] / far), rate], axis=1)


def to_positions(z: np.ndarray) -> np.ndarray:
    """Range, azimuth and elevation as x, y and z."""
    level = z[:, 0] * np.cos(z[:, 2])
    return np.stack([level * np.sin(z[:, 1]), level * np.cos(z[:, 1]), z[:, 0] * np.sin(z[:, 2])], axis=1)
