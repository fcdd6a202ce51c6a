"""What a page of plots without identity shows beside its tracks."""

from __future__ import annotations

import numpy as np
import polars as pl

from ..association.batch import Found
from ..frozen import frozen
from ..io.geodesy import SiteFrame
from .placing import Placed


@frozen
class SkyPicture:
    """Tables with time and x, y (m), and latitude, longitude where there is a map.

    plots: also lone (the probability that it is no track's) and used (a track's). tentative: also track and existence,
    of tracks that were never confirmed. scans: how many. truth: also target, where it is known. series: of each target
    of the tracks' table the name of what tracked it, where several did; the first is shown at first.
    """

    plots: pl.DataFrame
    tentative: pl.DataFrame
    scans: int
    truth: pl.DataFrame | None = None
    series: dict[str, str] | None = None


def sky_picture(plots: Placed, found: Found) -> SkyPicture:
    """Of one pass over the plots."""
    used = np.zeros(plots.rows.height, bool)
    used[found.plot[found.plot >= 0]] = True
    about = {"time": plots.rows["time"], "lone": np.nan_to_num(found.lone, nan=0.0), "used": used}
    young = found.tentative
    tentative = {"track": young.id, "time": young.time, "existence": young.existence}
    return SkyPicture(
        pl.DataFrame(about | _places(plots, plots.plane[:, 0], plots.plane[:, 1])),
        pl.DataFrame(tentative | _places(plots, young.position[:, 0], young.position[:, 1])),
        found.counts["scans"],
    )


def _places(plots: Placed, x: np.ndarray, y: np.ndarray) -> dict[str, np.ndarray]:
    if not isinstance(plots.frame, SiteFrame):
        return {"x": x, "y": y}
    latitude, longitude, _, _ = plots.frame.to_geographic(x, y, None)
    return {"x": x, "y": y, "latitude": latitude, "longitude": longitude}
