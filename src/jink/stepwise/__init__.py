"""Filters with models of the user's own: scan by scan in Python over the whole batch, with the native mix and
update.
"""

from .engine import Stepwise

__all__ = ["Stepwise"]
