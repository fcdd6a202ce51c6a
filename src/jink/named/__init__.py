"""Filters by name: one registry, which `jink track`, `jink compare` and the contract tests read.

A named filter is a function of a :class:`Purpose` that returns a :class:`Named`, in a file beside this one, and a line here.
"""

from __future__ import annotations

from collections.abc import Callable

from ..arguments import unknown
from .interacting import imm, imm_cv_ca, imm_cv_ct
from .learned import anfis_kf, fuzzy_imm_, fuzzy_kalman, nn_kf, nnvsmm
from .purpose import ACCELERATION, Named, Purpose, Unfit
from .single import kalman_ca, kalman_cv, singer

FILTERS: dict[str, Callable[[Purpose], Named]] = {
    "kalman-cv": kalman_cv,
    "kalman-ca": kalman_ca,
    "singer": singer,
    "imm": imm,
    "imm-cv-ca": imm_cv_ca,
    "imm-cv-ct": imm_cv_ct,
    "fuzzy-imm": fuzzy_imm_,
    "fuzzy-kalman": fuzzy_kalman,
    "anfis-kf": anfis_kf,
    "nn-kf": nn_kf,
    "nnvsmm": nnvsmm,
}
SHORT = {"cv": "kalman-cv", "ca": "kalman-ca"}

__all__ = ["ACCELERATION", "FILTERS", "SHORT", "Named", "Purpose", "Unfit", "canonical"]


def canonical(name: str) -> str:
    """The name in `FILTERS`, short ones spelled out. Errors: ValueError naming the nearest and all."""
    full = SHORT.get(name, name)
    if full not in FILTERS:
        raise ValueError(unknown("filter", name, FILTERS))
    return full
