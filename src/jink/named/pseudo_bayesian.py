"""The modes of `imm-cv-ca`, interacting otherwise."""

from __future__ import annotations

from ..filters.pseudo_bayesian import GPB1, GPB2, StaticMM
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
    """Static multiple models, which do not switch."""
    filter = StaticMM(cv_and_ca(purpose), purpose.seen, outliers=purpose.outliers)
    return Named(
        filter=filter, words="static multiple models of the modes of imm-cv-ca", fitted=descent(purpose)
    )
