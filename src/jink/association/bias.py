"""How far one radar's positions are off from another's, from targets that both have told the code of."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..checks import Array, by_hints
from ..times import seconds


class RadarBias(NamedTuple):
    """What to subtract from the other radar's plots: offset (axes,) and its standard error, in m; pairs it is from."""

    offset: Array
    se: Array
    pairs: int


@by_hints
def radar_bias(
    time: ArrayLike,
    plots: ArrayLike,
    code: ArrayLike,
    other_time: ArrayLike,
    other_plots: ArrayLike,
    other_code: ArrayLike,
    *,
    longest: float = 30.0,
) -> RadarBias:
    """Mean offset of the other radar's plots (m, axes) against this one's, both in one frame in metres.

    d = z'(t) − [(t₂ − t) z(t₁) + (t − t₁) z(t₂)]/(t₂ − t₁), for each plot z' of a target between two plots of the same
    code, not more than ``longest`` seconds apart. Each target's mean counts by its number of pairs, and the standard
    error comes from the spread over targets. Plots far from the rest (over 5 robust standard deviations, as of a code
    that was garbled) are left out. code: whole numbers from 0; plots with −1 do not count.
    Errors: ValueError where fewer than two targets have been seen by both.
    """
    one, other = _by_code(time, plots, code), _by_code(other_time, other_plots, other_code)
    found = {c: _differences(*one[c], *other[c], longest) for c in one.keys() & other.keys()}
    found = {c: d for c, d in sorted(found.items()) if len(d)}
    if len(found) < 2:
        raise ValueError(f"code: expected at least two targets that both radars have seen in turn, got {len(found)}")
    every = np.concatenate(list(found.values()))
    middle = np.median(every, axis=0)
    far = 1.4826 * np.median(np.abs(every - middle), axis=0)
    kept = [d[(np.abs(d - middle) <= 5.0 * far).all(axis=1)] for d in found.values()]
    count = np.array([len(d) for d in kept], float)
    total = np.array([d.sum(axis=0) for d in kept])
    offset = total.sum(axis=0) / count.sum()
    influence = (total - count[:, None] * offset) / count.mean()
    se = influence.std(axis=0, ddof=1) / np.sqrt(len(kept))
    return RadarBias(offset, se, int(count.sum()))


def _by_code(time: ArrayLike, plots: ArrayLike, code: ArrayLike) -> dict[int, tuple[Array, Array]]:
    t, z, c = np.asarray(seconds(time), float), np.asarray(plots, float), np.asarray(code)
    if z.ndim != 2 or t.shape != (len(z),) or c.shape != (len(z),) or not np.issubdtype(c.dtype, np.integer):
        raise ValueError(f"plots: expected (m, axes), with m times and whole numbers as codes; got {z.shape}")
    usable: NDArray[np.bool_] = np.isfinite(z).all(axis=1) & np.isfinite(t) & (c >= 0)
    order = np.flatnonzero(usable)[np.argsort(t[usable], kind="stable")]
    return {int(each): (t[order[c[order] == each]], z[order[c[order] == each]]) for each in np.unique(c[order])}


def _differences(t: Array, z: Array, other_t: Array, other_z: Array, longest: float) -> Array:
    """Of each of the other's plots between two of these, where it is off from the line between them."""
    after = np.searchsorted(t, other_t, side="left")
    inside = (after > 0) & (after < len(t))
    a, b, now, seen = after[inside] - 1, after[inside], other_t[inside], other_z[inside]
    gap = t[b] - t[a]
    near = (gap > 0) & (gap <= longest)
    a, b, now, seen, gap = a[near], b[near], now[near], seen[near], gap[near]
    share = ((now - t[a]) / gap)[:, None]
    return seen - (1.0 - share) * z[a] - share * z[b]
