"""Other libraries, one small file each, asked to do jink's jobs.

A peer module has NAME, DISTRIBUTION (on PyPI) and, for each job it can do, a function `kalman(case)`,
`imm(case)` or `live(case)` that returns a `Job`. CANNOT says for the others why not; a job that differs
from the reference's says so in its note.
"""

from __future__ import annotations

import importlib
import importlib.metadata
from types import ModuleType

PEERS = (
    "filterpy",
    "bayesian_filters",
    "kalbee",
    "nrl_tracker",
    "quakfilter",
    "stonesoup",
    "simdkalman",
    "dynamax",
)

LEFT_OUT = {
    "gri-kalman": "needs Python 3.12; has no 4-state model (tracks in earth-centred coordinates)",
    "torch-kf": "the wheel of torch brings CUDA, several GB",
}

JOBS = {
    "kalman": "Kalman filter, 4 states, own covariance per track",
    "imm": "IMM, 3 modes of 4 states, per track",
    "live": "one live update of one IMM track",
}


def load(key: str, package: str = __name__) -> tuple[ModuleType | None, str]:
    """The peer's module in this package, or another, and its version; or None and why it is missing."""
    try:
        module = importlib.import_module(f"{package}.{key}")
    except ImportError as error:
        return None, f"not installed ({error})"
    return module, importlib.metadata.version(module.DISTRIBUTION)
