"""What a run read, cleaned, assumed, filtered and found: one dictionary for people, pages and machines."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import polars as pl

from ..catalogue.choose import axes_of
from ..io.loading import Loaded
from ..io.measurements import Measurements
from .cleaning import Cleaned, changes
from .output import nis_share
from .prepare import Group, Settings

CLEANED = {
    "unsorted": "rows sorted by time",
    "out_of_order": "rows rejected because time runs backwards",
    "duplicate_times": "rows rejected because their time occurs twice",
    "shared_times": "rows whose time stamp another row at another place has: of each time the first is kept",
    "stale_positions": "stale (repeated) positions taken as missing",
    "missing_positions": "rows without a position, predicted",
    "without_position": "rows rejected because no position is near in time",
    "wrong_starts": "first positions rejected because the next contradict them",
    "impossible_heights": "heights taken as missing: nothing climbs to them and back so fast",
    "height_jumps": "jumps in height that nothing climbs: the heights on one side of each are wrong",
    "gaps": "gaps that begin a new part",
    "short_parts": "parts rejected as too short",
}


def in_the_plane(which: str, measurements: Measurements, filter: Any) -> str:
    """The note on parts without a third axis: they have no heights, or the filter that was asked for takes none."""
    if axes_of(filter) == 2 and measurements.named.keys() & {"altitude", "z"}:
        return f"{which} parts are tracked in the plane (2-D), as the filter has two axes; heights are not used"
    return f"{which} parts have no altitude and are tracked in the plane (2-D)"


def own_noise(settings: Settings, measurements: Measurements) -> list[str]:
    """A note where a filter is not given the noise that is estimated, because it has a sensor with a noise."""
    filter = settings.filter
    if filter is None or isinstance(filter, str) or settings.sensor_sd:
        return []
    sensor = next(iter(getattr(filter, "sensors", ())), None)
    converted = measurements.position == "polar" and "range" not in getattr(sensor, "components", ())
    if converted or getattr(filter, "fitted", {}).get("noise") == "of each row":
        return []
    sd = getattr(sensor, "sd", None)
    own = f"noise of {sd:.3g} m" if isinstance(sd, int | float) else "noise"
    return [f"the filter keeps its sensor's own {own}, and the noise estimated here is not used; --sensor-sd gives one"]


def not_corrected(filters: Iterable[Any], settings: Settings) -> list[str]:
    """A note where estimates are smoothed, which a learned correction leaves as they are."""
    if settings.smoothing is None:
        return []
    from ..filters.corrected import Corrected

    if not any(isinstance(filter, Corrected) for filter in filters):
        return []
    return [
        "the filter's learned correction is one of filtered estimates; smoothed, they are those of the filter under "
        "it, without a correction"
    ]


def summarise(
    loaded: Loaded,
    cleaned: Cleaned,
    rejected: pl.DataFrame,
    groups: Sequence[Group],
    tracks: pl.DataFrame,
    settings: Settings,
) -> dict[str, Any]:
    """Counts that add up (rows = accepted + rejected), all that was assumed, noise, status, consistency."""
    times = tracks["time"]
    parts_of = tracks.select("target", "part")[np.flatnonzero(changes(tracks["target"], tracks["part"]))]
    flat = [group.placed for group in groups if group.placed.axes == 2]
    notes = list(loaded.measurements.notes)
    if flat and loaded.measurements.position != "polar":
        parts = sum(int(group.new.sum()) for group in flat)
        which = "all" if len(groups) == 1 else f"{parts}"
        notes.append(in_the_plane(which, loaded.measurements, settings.filter))
    notes += own_noise(settings, loaded.measurements)
    notes += not_corrected((group.filter for group in groups), settings)
    used = [group.rates for group in groups if group.rates.notes]
    if any(rates.sd for rates in used):
        notes += loaded.measurements.rate_notes
    notes += [note for rates in used for note in rates.notes]
    return {
        "files": loaded.files,
        "rows": loaded.count,
        "accepted": tracks.height,
        "rejected": {reason: count for reason, count in reasons(rejected)},
        "targets": parts_of["target"].n_unique(),
        "parts": parts_of.n_unique(),
        "start": plain(times.min()),
        "end": plain(times.max()),
        "columns": loaded.measurements.named,
        "unused_columns": loaded.measurements.unused,
        "notes": notes,
        "cleaning": {name: count for name, count in cleaned.counts.items() if name in CLEANED},
        "noise": [line | {"axes": group.placed.axes} for group in groups for line in group.level.sources],
        "filter": {f"{group.placed.axes} axes": words_for(group.filter) for group in groups},
        "status": {str(status): count for status, count in tracks["status"].value_counts(sort=True).iter_rows()},
        "consistency": nis_share(tracks),
    }


def reasons(rejected: pl.DataFrame) -> list[tuple[str, int]]:
    """Every reason with its count, the most frequent first; line-specific texts are put together."""
    general = pl.col("reason").str.replace(r"^line \d+ has .*", "line with a wrong number of fields")
    return [tuple(row) for row in rejected.select(general)["reason"].value_counts(sort=True).iter_rows()]


def words_for(chosen: Any) -> str:
    """The filter's class and modes."""
    under = getattr(chosen, "filter_", None)
    if under is not None:
        return f"{words_for(under)} with a learned correction"
    motions = getattr(chosen, "motions", None) or [getattr(chosen, "motion", None)]
    return f"{type(chosen).__name__}({', '.join(str(getattr(m, 'name', m)) for m in motions)})"


def plain(value: Any) -> Any:
    return value.isoformat(timespec="milliseconds") if hasattr(value, "isoformat") else value
