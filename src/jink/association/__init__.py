"""Many targets from plots without identity: the tracker, its picture, and what it is told."""

from .bias import RadarBias, radar_bias
from .picture import Picture
from .rules import ASSOCIATIONS
from .sectors import Sectors
from .tracker import Tracker

__all__ = ["ASSOCIATIONS", "Picture", "RadarBias", "Sectors", "Tracker", "radar_bias"]
