"""References that know what a filter does not: how much is left to gain."""

from .near_optimal import Reference, near_optimal
from .priors import Prior, RandomAccelerations, RandomTurns

# which prior judges which scenario; lee-2003's fixed manoeuvres: by one that believes in random ones
PRIORS: dict[str, Prior] = {
    "lee-2003": RandomAccelerations(),
    "random-accelerations": RandomAccelerations(),
    "random-turns": RandomTurns(),
}

__all__ = ["PRIORS", "Prior", "RandomAccelerations", "RandomTurns", "Reference", "near_optimal"]
