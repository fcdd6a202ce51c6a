"""The race of filters: who takes part, how runs are counted, what is said of it, and what no filter can beat."""

from .clairvoyant import clairvoyant
from .entrants import ALWAYS, ENTRANTS
from .near_optimal import Reference, near_optimal
from .priors import PRIORS, Prior, RandomAccelerations, RandomTurns
from .race import compare
from .result import Race
from .turned_axes import near_optimal_turned

__all__ = [
    "ALWAYS",
    "ENTRANTS",
    "PRIORS",
    "Prior",
    "Race",
    "RandomAccelerations",
    "RandomTurns",
    "Reference",
    "clairvoyant",
    "compare",
    "near_optimal",
    "near_optimal_turned",
]
