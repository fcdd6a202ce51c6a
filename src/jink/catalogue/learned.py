"""Learned filters: fuzzy process noise, aids of a Kalman filter, a network that chooses the noise.

They were trained on other sensors and targets than a purpose's, and are scaled to its sensor; what they were trained on
is said.
"""

from __future__ import annotations

import numpy as np

from ..filters.aided import Aided
from ..filters.fuzzy_imm import FuzzyNoise, fuzzy_imm
from ..filters.imm import IMM
from ..filters.kalman import Kalman
from ..filters.neural_vsmm import NetworkNoise, NeuralModes
from ..models.fuzzy import PUBLISHED, FuzzyRules
from ..models.motion import ConstantVelocity
from ..models.switching import Sojourn
from .purpose import Named, Purpose, Unfit
from .shipped import shipped
from .single import kalman_ca
from .targets import KINDS

LEE_SD, LEE_ACCELERATION = 500.0, 100.0  # m, m/s²: sensor and largest input of lee-2003
TRAINED_ON = "fighter"  # whose acceleration the rules along and across the track learned


def fuzzy_imm_(purpose: Purpose) -> Named:
    """The published rules of lee-2003, scaled to the sensor's sd and to what the targets pull; as printed where both
    are the paper's.
    """
    rules = [_scaled(table, *_scales(purpose, purpose.largest)) for table in PUBLISHED["lee-2003"]]
    filter = fuzzy_imm(purpose.seen, rules, purpose.staying(0.97, len(rules)), outliers=purpose.outliers)
    how = "as published" if _scales(purpose, purpose.largest) == (1.0, 1.0) else "scaled"
    return Named(filter=filter, words=f"IMM of three modes with the fuzzy noise of Lee, Joo & Park 2003, {how}")


def fuzzy_imm_along(purpose: Purpose) -> Named:
    """Three modes with fuzzy noise along and across the track, trained on fighters; scaled as the others."""
    if purpose.axes < 2:
        raise Unfit("its rules hold along and across the track; the sensor measures one axis")
    trained = shipped("fuzzy-imm-along")
    length = _sd(purpose) / trained.sensors[0].sd
    force = (purpose.largest / KINDS[TRAINED_ON].acceleration) ** 2
    motions = []
    for mode in trained.motions:
        along, across = (_scaled(table, length, force) for table in (mode.rules, mode.across))
        motions.append(FuzzyNoise(_with_mean_noise(along, across), along, across))
    stay = np.diag(trained.transition)
    switching = Sojourn(
        seconds=(-purpose.interval / np.log(stay)).tolist(),
        to=(trained.transition - np.diag(stay)) / (1.0 - stay)[:, None],
    )
    return Named(
        filter=IMM(motions, purpose.sensor, switching, outliers=purpose.outliers),
        words="IMM of three modes with fuzzy noise along and across the track, trained on targets that turn, weave and "
        "accelerate in any direction, scaled",
        fitted="other runs" if purpose.name in ("random-turns", "weave") else "",
    )


def _with_mean_noise(*tables: FuzzyRules) -> ConstantVelocity:
    return ConstantVelocity(acceleration_sd=float(np.sqrt(np.mean([w for t in tables for w in t.variances]))))


def fuzzy_kalman(purpose: Purpose) -> Named:
    """One mode with fuzzy noise, trained on random accelerations; elsewhere scaled to sensor and kind of target."""
    motion = shipped("fuzzy-kalman").motions[0]
    trained_here = purpose.name.startswith("random-accelerations")
    rules = _scaled(motion.rules, *_scales(purpose, purpose.largest if trained_here else purpose.acceleration))
    filter = Kalman(FuzzyNoise(motion.motion, rules), purpose.seen, outliers=purpose.outliers)
    return Named(
        filter=filter,
        words="Kalman filter with fuzzy noise trained on random accelerations, scaled",
        fitted="other runs" if purpose.name == "random-accelerations" else "",
    )


def _scaled(rules: FuzzyRules, length: float, force: float) -> FuzzyRules:
    """Residuals times one factor, variances times the other."""
    c, s, w = (np.asarray(a) for a in (rules.centres, rules.spreads, rules.variances))
    return FuzzyRules((c * length).tolist(), (s * length).tolist(), (w * force).tolist(), rules.trained)


def _scales(purpose: Purpose, acceleration: float) -> tuple[float, float]:
    """Factors of lengths and of variances; one each for the sensor and the targets of lee-2003."""
    return _sd(purpose) / LEE_SD, (acceleration / LEE_ACCELERATION) ** 2


def _sd(purpose: Purpose) -> float:
    sd = getattr(purpose.seen, "sd", None)
    return float(sd) if isinstance(sd, int | float) else purpose.sd


def anfis_kf(purpose: Purpose) -> Named:
    """The best constant-acceleration Kalman filter, aided by an ANFIS on its last innovations."""
    return _aided(purpose, "anfis-kf", "an ANFIS")


def nn_kf(purpose: Purpose) -> Named:
    """The best constant-acceleration Kalman filter, aided by a network on its last innovations."""
    return _aided(purpose, "nn-kf", "a network")


def _aided(purpose: Purpose, name: str, what: str) -> Named:
    corrector = shipped(name).corrector
    base = kalman_ca(purpose)
    words = f"{base.words}, aided by {what} trained on benchmark aircraft 1, 3 and 5"
    fitted = base.fitted or ("other runs" if purpose.name in ("benchmark-1", "benchmark-3", "benchmark-5") else "")
    return Named(filter=Aided(base.filter, corrector), words=words, fitted=fitted)


def nnvsmm(purpose: Purpose) -> Named:
    """A network chooses the noise in every scan; trained end to end on targets of all kinds, scaled to the sensor's
    sd.
    """
    _needs_a_plane(purpose)
    trained = shipped("nnvsmm").motions[0].network
    motion = NetworkNoise(ConstantVelocity(acceleration_sd=1.0), trained.scaled(_sd(purpose)))
    return Named(
        filter=Kalman(motion, purpose.sensor, outliers=purpose.outliers),
        words="Kalman filter whose noise a network chooses, trained on targets that change motion every few scans",
    )


def nnvsmm_modes(purpose: Purpose) -> Named:
    """A network scores five noise levels in every scan; trained likewise, its bank scaled to the sensor's sd."""
    trained = shipped("choi-2001-modes-wide", 0)
    sds = [_sd(purpose) * motion.acceleration_sd for motion in trained.motions]
    motions = [ConstantVelocity(acceleration_sd=sd) for sd in sds]
    return Named(
        filter=NeuralModes(motions, purpose.sensor, trained.network, outliers=purpose.outliers),
        words=f"{len(motions)} noise levels of which a network weighs the best {trained.network.best}, trained on "
        "targets that change motion every few scans",
    )


def _needs_a_plane(purpose: Purpose) -> None:
    if purpose.axes != 2:
        raise Unfit(f"its network was trained on two axes; the sensor has {purpose.axes}")
