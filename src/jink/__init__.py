"""jink: tracking of targets that manoeuvre."""

from typing import TYPE_CHECKING, Any

from .filters.estimate import STATUS, Estimate
from .filters.imm import IMM
from .filters.kalman import Kalman
from .filters.loading import load
from .motion import ConstantAcceleration, ConstantVelocity, CoordinatedTurn, KnownTurn, Singer
from .noise import OnePoint, Outliers, Prior, Sojourn, TwoPoint
from .sensor import Bearing, Polar, Position, PositionVelocity

if TYPE_CHECKING:
    from .tracking import track

__version__ = "0.1.0"

__all__ = [
    "IMM",
    "STATUS",
    "Bearing",
    "ConstantAcceleration",
    "ConstantVelocity",
    "CoordinatedTurn",
    "Estimate",
    "Kalman",
    "KnownTurn",
    "OnePoint",
    "Outliers",
    "Polar",
    "Position",
    "PositionVelocity",
    "Prior",
    "Singer",
    "Sojourn",
    "TwoPoint",
    "load",
    "track",
]


def __getattr__(name: str) -> Any:
    if name == "track":  # needs polars and pyproj, which the rest does not
        from .tracking import track

        return track
    raise AttributeError(f"module 'jink' has no attribute {name!r}")
