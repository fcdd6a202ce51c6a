"""One run of a sky as a page shows it: plots, truth, and the tracks of every entrant."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import polars as pl

from ..association.batch import Found, Scans, track_scans
from ..association.tracker import Tracker
from ..frozen import frozen
from ..scenarios.skies import SkyRun
from ..tracking.anonymous import sky_table
from ..tracking.anonymous_rows import placed_tracks
from ..tracking.manoeuvring import Manoeuvres
from ..tracking.placing import Placed, lay
from ..tracking.sky_picture import SkyPicture, sky_picture


@frozen
class SkyExample:
    """tracks: the table of all entrants' tracks; sky: what lies around them."""

    tracks: pl.DataFrame
    sky: SkyPicture


def example_of(run: SkyRun, trackers: Mapping[str, Tracker], kind: str) -> SkyExample:
    """Each tracker over the run; targets are of a kind, and called by the entrant and a number."""
    plots, scans = _plots(run)
    tables, pictures = [], []
    series: dict[str, str] = {}
    for label, tracker in trackers.items():
        found: Found = track_scans(tracker, scans)
        pictures.append(sky_picture(plots, found))
        if not len(found.id):
            continue
        table = sky_table(placed_tracks(plots, found), found, False, Manoeuvres.of(tracker.filter, kind))
        called = pl.format("{} {}", pl.lit(label), pl.col("target")) if len(trackers) > 1 else pl.col("target")
        tables.append(table.with_columns(target=called))
        series |= dict.fromkeys(tables[-1]["target"].unique(), label)
    tracks = pl.concat(tables, how="diagonal") if tables else pl.DataFrame(schema=["target", "time", "x", "y"])
    ordered = {name: series[name] for label in trackers for name in series if series[name] == label}
    picture = replace(pictures[0], truth=_truth(run), series=ordered if len(trackers) > 1 else None)
    return SkyExample(tracks, picture)


def _plots(run: SkyRun) -> tuple[Placed, Scans]:
    z = np.vstack([scan.z for scan in run.scans])
    begin = np.r_[0, np.cumsum([len(scan.z) for scan in run.scans])]
    time = np.array([scan.time for scan in run.scans])
    each = np.repeat(time, np.diff(begin))
    number = np.arange(len(z))
    rows = pl.DataFrame(
        {"file": 0, "row": number, "source": "sky", "target": "0", "time": each, "x": z[:, 0], "y": z[:, 1]}
    )
    rows = rows.with_columns(part=pl.lit(0, pl.Int32), measured=pl.lit(True))
    return lay(rows, "cartesian", None, 2, None), Scans(time, begin, z)


def _truth(run: SkyRun) -> pl.DataFrame:
    ids = np.concatenate([picture.ids for picture in run.truth])
    points = np.vstack([picture.points for picture in run.truth])
    each = np.repeat([scan.time for scan in run.scans], [len(picture.ids) for picture in run.truth])
    return pl.DataFrame({"target": ids, "time": each, "x": points[:, 0], "y": points[:, 1]})
