"""Filters by name: the one registry that `jink track`, `jink compare` and the contract tests read.

A named filter is a function of a :class:`Purpose` that returns a :class:`Named`, in a file beside this one, and a line
here.
"""

from __future__ import annotations

from collections.abc import Callable

from ..checks import unknown
from .adaptive import aimm3, aimm5, augmented, two_stage
from .corrected import imm_corrected
from .current_statistical import csaf, facs, imm_facs
from .detecting import input_estimation, variable_dimension
from .interacting import imm, imm_cv_ca, imm_cv_ct
from .learned import anfis_kf, fuzzy_imm_, fuzzy_imm_along, fuzzy_kalman, nn_kf, nnvsmm, nnvsmm_modes
from .pseudo_bayesian import gpb1, gpb2, static
from .purpose import Named, Purpose, Unfit
from .single import kalman_ca, kalman_cv, singer
from .variable_structure import vsmm_ad, vsmm_ag, vsmm_ds

FILTERS: dict[str, Callable[[Purpose], Named]] = {
    "kalman-cv": kalman_cv,
    "kalman-ca": kalman_ca,
    "singer": singer,
    "imm": imm,
    "imm-cv-ca": imm_cv_ca,
    "imm-cv-ct": imm_cv_ct,
    "imm-facs": imm_facs,
    "imm-corrected": imm_corrected,
    "csaf": csaf,
    "facs": facs,
    "two-stage": two_stage,
    "augmented": augmented,
    "aimm3": aimm3,
    "aimm5": aimm5,
    "gpb1": gpb1,
    "gpb2": gpb2,
    "mm": static,
    "vsmm-ds": vsmm_ds,
    "vsmm-ad": vsmm_ad,
    "vsmm-ag": vsmm_ag,
    "input-estimation": input_estimation,
    "variable-dimension": variable_dimension,
    "fuzzy-imm": fuzzy_imm_,
    "fuzzy-imm-along": fuzzy_imm_along,
    "fuzzy-kalman": fuzzy_kalman,
    "anfis-kf": anfis_kf,
    "nn-kf": nn_kf,
    "nnvsmm": nnvsmm,
    "nnvsmm-modes": nnvsmm_modes,
}
SHORT = {"cv": "kalman-cv", "ca": "kalman-ca"}

__all__ = ["FILTERS", "SHORT", "Named", "Purpose", "Unfit", "canonical"]


def canonical(name: str) -> str:
    """The name in `FILTERS`, short ones spelled out. Errors: ValueError naming the nearest and all."""
    full = SHORT.get(name, name)
    if full not in FILTERS:
        raise ValueError(unknown("filter", name, FILTERS))
    return full
