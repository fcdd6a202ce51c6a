"""From a table of positions to tracks: prepared, filtered, written; in one batch, or live."""

from .batch import Tracked, track

__all__ = ["Tracked", "track"]
