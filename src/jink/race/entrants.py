"""Who may race: `FILTERS` by name, and filters from files; each is made for what it will see."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..default_filter import ACCELERATION, default_filter
from ..filters.imm import IMM
from ..filters.kalman import Kalman
from ..filters.loading import load
from ..io.errors import InputError
from ..motion import ConstantAcceleration, ConstantVelocity, CoordinatedTurn, Singer
from ..noise import Outliers, Sojourn
from ..scenarios import SCENARIOS
from ..scenarios.scenario import unknown
from ..sensor import Position
from .tuning import best_noise

ALWAYS = ("raw", "kalman-cv", "kalman-ca", "imm", "clairvoyant")
SUFFIX = ".json"
# what the parameters that are not found here were found on, which the race has to say (docs/default-filters.md)
FAMILIES = ("lee-2003", "random-accelerations", "random-accelerations-turned", "random-turns")
SEARCHED = "the default's search, on other draws"
DESCENDED = "its proportions come from filters tuned on other draws"
FLIGHTS = (
    "its parameters were fitted on half of the flights of the collection quickstart of the package traffic"
)


class Unfit(ValueError):
    """This filter cannot take part here; the message says why."""


@dataclass(frozen=True, kw_only=True)
class Course:
    """What a filter is made for: the sensor, the kind of target, and training data to be fitted on.

    sd (m) of a measured position; interval (s) between scans; loss(filter) on the training data; fitted, that
    data in words; per_axis: filters that can run along each axis by itself; name, a scenario's or a file's.
    """

    name: str
    kind: str
    sensor: Any
    sd: float
    interval: float
    loss: Callable[[Any], float]
    fitted: str
    per_axis: bool = False
    outliers: Outliers | None = None

    @property
    def axes(self) -> int:
        """Of the space the filter works in."""
        return int(self.sensor.axes or 2)

    @property
    def acceleration(self) -> float:
        """What this kind of target pulls when it manoeuvres, m/s²."""
        return ACCELERATION[self.kind]

    @property
    def seen(self) -> Any:
        """The sensor a filter is built for: one axis of it where filters run along each axis."""
        sd = getattr(self.sensor, "sd", None)
        if self.per_axis and isinstance(self.sensor, Position) and isinstance(sd, int | float):
            return Position(sd=sd, axes=1)
        return self.sensor


@dataclass(frozen=True, kw_only=True)
class Entrant:
    """A filter in the race: an engine's, or (filter None) one that :mod:`jink.race.simulated` knows by name.

    words: what it is; fitted: on which data of this race's own scenario, "" for none; in_sample: on the very
    runs that are scored; note: what else a reader must know.
    """

    name: str
    words: str
    filter: Any = None
    fitted: str = ""
    in_sample: bool = False
    note: str = ""


def _tuned(
    course: Course, name: str, make: Callable[[float], Any], what: str, unit: str, scale: float
) -> Entrant:
    noise = best_noise(lambda q: course.loss(make(q)), 1e-8 * scale, 1e4 * scale)
    return Entrant(
        name=name, words=f"Kalman filter, {what} {noise:.3g} {unit}", filter=make(noise), fitted=course.fitted
    )


def kalman_cv(course: Course) -> Entrant:
    """The best constant velocity Kalman filter for this course."""
    return _tuned(
        course,
        "kalman-cv",
        lambda q: Kalman(ConstantVelocity(acceleration_psd=q), course.seen, outliers=course.outliers),
        "constant velocity, acceleration_psd",
        "m²/s³",
        course.sd**2 / course.interval**3,
    )


def kalman_ca(course: Course) -> Entrant:
    """The best constant acceleration Kalman filter for this course."""
    prior = course.acceleration
    return _tuned(
        course,
        "kalman-ca",
        lambda q: Kalman(
            ConstantAcceleration(jerk_psd=q, acceleration_prior_sd=prior),
            course.seen,
            outliers=course.outliers,
        ),
        "constant acceleration, jerk_psd",
        "m²/s⁵",
        course.sd**2 / course.interval**5,
    )


def singer(course: Course) -> Entrant:
    """Singer's filter with half the kind's acceleration as sd and a time constant of 20 s, not fitted."""
    motion = Singer(acceleration_sd=0.5 * course.acceleration, time_constant=20.0)
    words = f"Singer, acceleration_sd {motion.acceleration_sd:g} m/s², time_constant 20 s"
    return Entrant(name="singer", words=words, filter=Kalman(motion, course.seen, outliers=course.outliers))


def imm(course: Course) -> Entrant:
    """The default filter of the kind of target; in one axis, where none turns, IMM of CV and CA."""
    if course.axes == 1:
        filter = imm_cv_ca(course).filter
        return Entrant(name="imm", words="IMM of CV and CA: one axis", filter=filter)
    filter = default_filter(course.kind, course.sensor, course.axes)
    modes = ", ".join(getattr(filter, "modes", ()))
    recorded = course.kind == "aircraft" and course.name not in SCENARIOS
    return Entrant(
        name="imm",
        words=f"default IMM for {course.kind}: {modes}",
        filter=filter,
        fitted=SEARCHED if course.name in FAMILIES else "",
        note=FLIGHTS if recorded else "",
    )


def imm_cv_ca(course: Course) -> Entrant:
    """IMM of constant velocity and constant acceleration, noises in proportion to the kind's acceleration."""
    a = course.acceleration
    modes = [
        ConstantVelocity(acceleration_psd=(a / 40) ** 2),
        ConstantAcceleration(jerk_psd=(a / 40) ** 2, acceleration_prior_sd=a),
    ]
    filter = IMM(modes, course.seen, Sojourn(seconds=[70.0, 16.0]), outliers=course.outliers)
    words = f"IMM of CV and CA, acceleration prior sd {a:g} m/s², mean stays 70 and 16 s"
    return Entrant(name="imm-cv-ca", words=words, filter=filter, fitted=_descent(course))


def _descent(course: Course) -> str:
    return DESCENDED if course.name in FAMILIES else ""


def imm_cv_ct(course: Course) -> Entrant:
    """IMM of constant velocity and coordinated turn."""
    if course.axes == 1:
        raise Unfit("turns need a plane, and the sensor has one axis")
    a = course.acceleration
    modes = [
        ConstantVelocity(acceleration_psd=(a / 40) ** 2),
        CoordinatedTurn(acceleration_psd=(a / 20) ** 2, turn_rate_psd=2.5e-7, turn_rate_prior_sd=0.06),
    ]
    filter = IMM(modes, course.sensor, Sojourn(seconds=[70.0, 16.0]), outliers=course.outliers)
    return Entrant(
        name="imm-cv-ct",
        words="IMM of CV and CT, turn rate prior sd 3.4°/s, mean stays 70 and 16 s",
        filter=filter,
        fitted=_descent(course),
    )


def raw(course: Course) -> Entrant:
    """No filter."""
    return Entrant(name="raw", words="the measurements themselves, velocity by differences")


def clairvoyant(course: Course) -> Entrant:
    """The Kalman filter that knows the commanded accelerations."""
    return Entrant(
        name="clairvoyant", words="Kalman filter that is told every manoeuvre: a lower bound, no filter"
    )


def near_optimal(course: Course) -> Entrant:
    """The hypothesis tree that knows how the targets are drawn."""
    fixed = course.name == "lee-2003"
    words = "hypothesis tree that " + (
        "believes in random accelerations: no bound" if fixed else "knows how the targets are drawn"
    )
    return Entrant(name="near-optimal", words=words)


FILTERS: dict[str, Callable[[Course], Entrant]] = {
    "raw": raw,
    "kalman-cv": kalman_cv,
    "kalman-ca": kalman_ca,
    "singer": singer,
    "imm": imm,
    "imm-cv-ca": imm_cv_ca,
    "imm-cv-ct": imm_cv_ct,
    "clairvoyant": clairvoyant,
    "near-optimal": near_optimal,
}


def check_names(names: list[str]) -> list[str]:
    """The names asked for, "all" spelled out, those that are always there first; no name twice.

    Errors: InputError for an unknown name (with the nearest and all), or a file that is not there.
    """
    wanted = [n for name in names for n in (FILTERS if name == "all" else [name])]
    for name in wanted:
        if name.endswith(SUFFIX):
            if not Path(name).is_file():
                raise InputError(f"there is no filter file {name}")
        elif name not in FILTERS:
            raise InputError(unknown("filter", name, FILTERS) + ", all, or a file written by save() (*.json)")
    return list(dict.fromkeys([*ALWAYS, *wanted]))


def from_file(path: str, course: Course, seed: int, runs: int) -> Entrant:
    """A filter written by ``save``, if it suits the sensor.

    The file may say what it was fitted on: "fitted": {"scenario", "seed", "runs"}. Errors: InputError.
    """
    try:
        filter = load(path)
    except (ValueError, OSError) as error:
        raise InputError(f"filter file {error}" if str(path) in str(error) else f"{path}: {error}") from None
    note = suits(filter, course, path)
    fitted = json.loads(Path(path).read_text(encoding="utf-8")).get("fitted") or {}
    here = isinstance(fitted, dict) and fitted.get("scenario") == course.name
    words = f"{type(filter).__name__} of {', '.join(filter.modes)}"
    return Entrant(
        name=path,
        words=words,
        filter=filter,
        fitted=f"{fitted.get('runs', 'some')} runs of seed {fitted.get('seed', '?')}" if here else "",
        in_sample=here and fitted.get("seed") == seed,
        note=note,
    )


def suits(filter: Any, course: Course, path: str) -> str:
    """A note where the filter assumes another noise. Errors: InputError where it cannot take the measurements."""
    own, there = filter.sensors[0], course.sensor
    expected, given = tuple(getattr(own, "components", ())), tuple(there.components)
    along_axes = isinstance(there, Position) and expected == ("x",)
    if expected != given and not along_axes:
        raise InputError(
            f"{path}: its sensor measures {', '.join(expected)}; {course.name} is seen by a sensor of {', '.join(given)}"
        )
    for name in ("site", "reference"):
        if getattr(own, name, None) != getattr(there, name, None):
            raise InputError(
                f"{path}: its sensor's {name} is {getattr(own, name, None)}; expected {getattr(there, name, None)}"
            )
    noise, actual = own.native()[9], there.native()[9]
    return "" if noise == actual[: len(noise)] else "assumes another measurement noise than there is"
