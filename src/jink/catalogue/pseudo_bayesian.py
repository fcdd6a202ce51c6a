"""The modes of `imm-cv-ca`, interacting otherwise, or not at all."""

from __future__ import annotations

from ..filters.pseudo_bayesian import GPB1, GPB2, StaticMM
from ..models.motion import ConstantAcceleration
from .interacting import STAYS, cv_and_ca, descent
from .purpose import Named, Purpose


def gpb1(purpose: Purpose) -> Named:
    """Pseudo-Bayesian of first order."""
    filter = GPB1(cv_and_ca(purpose), purpose.seen, STAYS, outliers=purpose.outliers)
    return Named(filter=filter, words="GPB1 of the modes of imm-cv-ca", fitted=descent(purpose))


def gpb2(purpose: Purpose) -> Named:
    """Pseudo-Bayesian of second order."""
    filter = GPB2(cv_and_ca(purpose), purpose.seen, STAYS, outliers=purpose.outliers)
    return Named(filter=filter, words="GPB2 of the modes of imm-cv-ca", fitted=descent(purpose))


def static(purpose: Purpose) -> Named:
    """Static multiple models, which do not switch: the mode that accelerates has to follow the changes by itself."""
    a = purpose.acceleration
    quiet, _ = cv_and_ca(purpose)
    busy = ConstantAcceleration(jerk_psd=(a / 8) ** 2, acceleration_prior_sd=a)
    filter = StaticMM([quiet, busy], purpose.seen, outliers=purpose.outliers)
    words = f"static multiple models, CV as in imm-cv-ca and CA of jerk_psd {busy.jerk_psd:.3g} m²/s⁵"
    return Named(filter=filter, words=words)
