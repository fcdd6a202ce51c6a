"""Errors of positions that last for several rows, as those of satellite receivers do: found and carried.

The error of a receiver wanders over some seconds. Third differences see its changes alone. A filter that takes these
for all noise follows the error, and says that it does not. So the noise of such positions is the whole error, and what
no filter takes out of it is added to the variance of each estimated position: `KEPT` of the error's. Simulated targets
decide that share (`python -m benchmarks.lasting_errors`).
"""

from __future__ import annotations

import numpy as np

from .correlated import correlated_errors

FIGURES = ("lasting_sd", "lasting_seconds")  # of a source: m and s
KEPT = 0.75  # of the variance of errors that last
LARGER = 1.5  # times the sd that third differences show
SHARE = 0.5  # of the parts of a source that can tell: fewer are chance
SOME = 0.2  # of all its parts: turning targets cannot tell


def lasting_errors(
    time: np.ndarray, plane: np.ndarray, new: np.ndarray, group: np.ndarray, white: np.ndarray, of_source: np.ndarray
) -> np.ndarray:
    """Sd (m) and duration (s) of the errors of each group (2, G), NaN where they do not last.

    time (N,) s, plane (N, 2) m, new (N,) marks first rows of parts; group (N,) of each row, of_source (G,) the source
    of each group; white (G,): sds as third differences show them. Groups that turn and cannot tell have the
    usual errors of their source.
    """
    part = np.cumsum(new) - 1
    first = np.flatnonzero(new)
    told = correlated_errors(time, plane, part, first.size)
    figures = np.array([told.sd, told.seconds])
    of_part = group[first]
    with np.errstate(invalid="ignore"):
        found = figures[0] > LARGER * white[of_part]
    out = np.full((2, white.size), np.nan)
    for source in np.unique(of_source[of_part[found]]):
        mine = of_source[of_part] == source
        usual = np.median(figures[:, mine & found], axis=1)
        may = mine & told.may_have(*usual)
        if found[mine].mean() < SOME or found[mine].sum() < SHARE * (mine & (found | ~may)).sum():
            continue
        for number in np.unique(of_part[mine & found]):
            out[:, number] = np.median(figures[:, found & (of_part == number)], axis=1)
        # what turns hides its errors; it has those of the targets that go straight
        hidden = np.setdiff1d(of_part[may], of_part[found])
        out[:, hidden] = usual[:, None]
    return out


def kept(errors: np.ndarray, group: np.ndarray) -> np.ndarray | None:
    """What positions keep of errors that last: a variance (N,) by row, None where none lasts."""
    if not np.isfinite(errors[0]).any():
        return None
    return KEPT * np.nan_to_num(errors[0][group]) ** 2


def said(errors: np.ndarray, of_source: np.ndarray, number: int) -> dict[str, float]:
    """The figures of one source."""
    mine = errors[:, of_source == number]
    if not np.isfinite(mine).any():
        return {}
    return {name: float(np.nanmedian(each)) for name, each in zip(FIGURES, mine, strict=True)}
