"""What `jink fit --search` tries: one to three motion models, adaptive and fuzzy filters, and where the fit of each
starts.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import combinations
from typing import Any

from ..catalogue.purpose import Purpose, Unfit
from ..catalogue.registry import FILTERS, canonical
from ..compare.own_filters import made
from ..filters.current_statistical import CurrentStatistical
from ..filters.imm import IMM
from ..filters.kalman import Kalman
from ..frozen import frozen
from ..io.own_code import loaded
from ..models.motion import ConstantAcceleration, ConstantVelocity, CoordinatedTurn, Singer
from ..models.switching import Sojourn

VERTICAL = 0.35  # of the horizontal accelerations, where height is measured
QUIET, MANOEUVRE = 60.0, 16.0  # s: mean stays that the fits start from


@frozen(kw_only=True)
class Candidate:
    """A filter to be fitted: made(purpose); parts, what it is made of, by the keys of `WORDS`;
    code: the file and name of one of your own."""

    name: str
    parts: tuple[str, ...]
    made: Callable[[Purpose], Any]
    code: str = ""


# what a part of a filter is for, as an explanation says it
WORDS = {
    "cv": "straight flight with random accelerations",
    "ca": "accelerations that last",
    "ct": "turns at a rate of their own",
    "singer": "accelerations that fade",
    "csm": "accelerations whose spread follows their size",
    "several": "more than one mode",
    "fuzzy": "noise set by fuzzy rules from the residual",
    "adaptive": "levels around an estimated acceleration",
    "own": "a filter of your own",
}


def _scaled(purpose: Purpose, value: float, power: int = 1) -> Any:
    """The same along the horizontal axes, smaller upwards."""
    if purpose.seen.axes != 3:
        return value
    return (value, value, value * VERTICAL**power)


def _cv(purpose: Purpose, times: float = 1.0) -> Any:
    return ConstantVelocity(acceleration_psd=_scaled(purpose, (times * purpose.acceleration / 40) ** 2, 2))


def _ca(purpose: Purpose) -> Any:
    a = purpose.acceleration
    return ConstantAcceleration(
        jerk_psd=_scaled(purpose, (a / 40) ** 2, 2), acceleration_prior_sd=_scaled(purpose, a / 2)
    )


def _ct(purpose: Purpose) -> Any:
    if purpose.seen.axes == 1:
        raise Unfit("turns need two axes together; here each axis is filtered by itself")
    noise = _scaled(purpose, (purpose.acceleration / 20) ** 2, 2)
    return CoordinatedTurn(acceleration_psd=noise, turn_rate_psd=2.5e-7, turn_rate_prior_sd=0.06)


def _singer(purpose: Purpose) -> Any:
    return Singer(acceleration_sd=_scaled(purpose, 0.5 * purpose.acceleration), time_constant=20.0)


def _csm(purpose: Purpose) -> Any:
    a = purpose.acceleration
    return CurrentStatistical(acceleration_max=2.25 * a, time_constant=20.0, acceleration_prior_sd=0.75 * a)


MODES: dict[str, Callable[[Purpose], Any]] = {"cv": _cv, "ca": _ca, "ct": _ct, "singer": _singer, "csm": _csm}


def _composed(names: tuple[str, ...], noises: tuple[float, ...] = ()) -> Callable[[Purpose], Any]:
    def made(purpose: Purpose) -> Any:
        modes = [_cv(purpose, times) for times in noises] or [MODES[name](purpose) for name in names]
        if len(modes) == 1:
            return Kalman(modes[0], purpose.seen, outliers=purpose.outliers)
        stays = Sojourn(seconds=[QUIET] + [MANOEUVRE] * (len(modes) - 1))
        return IMM(modes, purpose.seen, stays, outliers=purpose.outliers)

    return made


def _named(name: str) -> Callable[[Purpose], Any]:
    return lambda purpose: FILTERS[name](purpose).filter


def _all() -> list[Candidate]:
    single = [(name,) for name in MODES]
    others = [name for name in MODES if name != "cv"]
    several = [("cv", *more) for k in (1, 2) for more in combinations(others, k)]
    found = [Candidate(name=a, parts=(a,), made=_composed((a,))) for (a,) in single]
    found += [
        Candidate(name="2cv", parts=("cv", "several"), made=_composed((), (0.5, 20.0))),
        Candidate(name="3cv", parts=("cv", "several"), made=_composed((), (0.5, 8.0, 40.0))),
    ]
    found += [Candidate(name="+".join(m), parts=(*m, "several"), made=_composed(m)) for m in several]
    more = {
        "facs": ("csm", "fuzzy"),
        "imm-facs": ("cv", "csm", "fuzzy", "several"),
        "fuzzy-kalman": ("cv", "fuzzy"),
        "fuzzy-imm": ("cv", "fuzzy", "several"),
        "augmented": ("cv", "adaptive"),
        "aimm3": ("cv", "adaptive", "several"),
        "imm": ("cv", "ca", "ct", "several"),
    }
    return found + [Candidate(name=name, parts=parts, made=_named(name)) for name, parts in more.items()]


def own_candidates(text: str) -> list[Candidate]:
    """Filters of your own from "file.py:name", which may be a mapping of them. Errors: InputError."""
    found = loaded(text)
    several = found if isinstance(found, Mapping) else {text: found}
    return [Candidate(name=name, parts=("own",), made=_own(name, given), code=text) for name, given in several.items()]


def _own(name: str, given: Any) -> Callable[[Purpose], Any]:
    if given is None:
        return _named(canonical(name))
    return lambda purpose: made(name, given, purpose).filter


CANDIDATES: dict[str, Candidate] = {candidate.name: candidate for candidate in _all()}
