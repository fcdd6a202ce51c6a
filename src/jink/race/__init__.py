"""The race behind :func:`jink.compare.compare`: who takes part, how runs are counted, what is said of it."""

from .entrants import ALWAYS, ENTRANTS
from .result import Race

__all__ = ["ALWAYS", "ENTRANTS", "Race"]
