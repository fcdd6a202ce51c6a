"""`jink fit`: a filter learned from your own targets; what it is fitted on, what came of it, and a search over many."""

from .fitting import OBJECTIVES, Fit, fit

__all__ = ["OBJECTIVES", "Fit", "fit"]
