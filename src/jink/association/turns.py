"""A recording of an antenna that turns, sector by sector."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .batch import Found, Pictures, Scans, track_scans
from .sectors import Sectors
from .tracker import Tracker


def track_turns(
    tracker: Tracker, scans: Scans, progress: Callable[[int, int], None] | None = None, *, keep: bool = False
) -> Found:
    """As ``track_scans``; a track has a row in the sector where it was due, or had a plot: one in a turn."""
    return track_scans(tracker, scans, progress, keep=keep, pictures=_by_turns(tracker, scans))


def _by_turns(tracker: Tracker, scans: Scans) -> Pictures:
    """One of each sector; its number is that of the turn that its middle is in."""
    turning = scans.turning
    if turning is None or scans.own is None:
        raise ValueError("scans: expected an antenna that turns, and times of plots")
    sectors = Sectors(tracker, turning.period, count=turning.sectors, clockwise=turning.clockwise)
    for pictures in (sectors.each(scans.own, scans.z), sectors.rest()):
        for picture in pictures:
            yield int(scans.turn_of(np.array([picture.time]))[0]), picture, picture.report["offered"]
