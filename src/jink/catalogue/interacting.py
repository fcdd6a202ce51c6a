"""IMM filters: the default of each kind of target, and two of two modes."""

from __future__ import annotations

from ..filters.imm import IMM
from ..models.motion import ConstantAcceleration, ConstantVelocity, CoordinatedTurn, Motion
from ..models.switching import Sojourn
from .purpose import Named, Purpose, Unfit
from .targets import KINDS, RARE

# what the parameters that are not found here were found on, which a comparison has to say (docs/default-filters.md)
FAMILIES = ("lee-2003", "random-accelerations", "random-accelerations-turned", "random-turns")
SEARCHED = "the default's search, on other draws"
DESCENDED = "its proportions come from filters tuned on other draws"
FLIGHTS = "its parameters were fitted on half of the flights of the collection quickstart of the package traffic"
STAYS = Sojourn(seconds=[70.0, 16.0])


def imm(purpose: Purpose) -> Named:
    """The default filter of the kind of target; in one axis, where none turns, IMM of CV and CA."""
    if purpose.axes == 1:
        return Named(filter=imm_cv_ca(purpose).filter, words="IMM of CV and CA, because the sensor has one axis")
    waits = {} if purpose.gap is None else {"interval": purpose.gap / RARE, "coast": 0.0}
    filter = KINDS[purpose.kind].filter(purpose.sensor, purpose.axes, **waits)
    return Named(
        filter=filter,
        words=f"default IMM for {purpose.kind}: {', '.join(filter.modes)}",
        fitted=SEARCHED if purpose.name in FAMILIES else "",
        note=FLIGHTS if purpose.recorded and purpose.kind == "aircraft" else "",
    )


def imm_cv_ca(purpose: Purpose) -> Named:
    """IMM of constant velocity and constant acceleration, noises in proportion to the kind's acceleration."""
    return Named(
        filter=IMM(cv_and_ca(purpose), purpose.seen, STAYS, outliers=purpose.outliers),
        words=f"IMM of CV and CA, acceleration prior sd {purpose.acceleration:g} m/s², mean stays 70 and 16 s",
        fitted=descent(purpose),
    )


def cv_and_ca(purpose: Purpose) -> list[Motion]:
    """The two modes of `imm-cv-ca` and of the filters that differ from it in how modes interact."""
    a = purpose.acceleration
    return [
        ConstantVelocity(acceleration_psd=(a / 40) ** 2),
        ConstantAcceleration(jerk_psd=(a / 40) ** 2, acceleration_prior_sd=a),
    ]


def imm_cv_ct(purpose: Purpose) -> Named:
    """IMM of constant velocity and coordinated turn."""
    if purpose.axes == 1:
        raise Unfit("turns need two axes; the sensor has one")
    a = purpose.acceleration
    modes = [
        ConstantVelocity(acceleration_psd=(a / 40) ** 2),
        CoordinatedTurn(acceleration_psd=(a / 20) ** 2, turn_rate_psd=2.5e-7, turn_rate_prior_sd=0.06),
    ]
    return Named(
        filter=IMM(modes, purpose.sensor, STAYS, outliers=purpose.outliers),
        words="IMM of CV and CT, turn rate prior sd 3.4°/s, mean stays 70 and 16 s",
        fitted=descent(purpose),
    )


def descent(purpose: Purpose) -> str:
    """Where the proportions of `imm-cv-ca` and `imm-cv-ct` come from, if from data like these."""
    return DESCENDED if purpose.name in FAMILIES else ""
