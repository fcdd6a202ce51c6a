"""Coasts, borders and lakes behind the tracks, from Natural Earth; `scripts/world_map.py` makes the file."""

from importlib import resources
from io import BytesIO

import numpy as np

from .arrays import ArrayBlock

_UNIT = 1e-3  # degrees
_LEAST_MARGIN = 50_000.0  # metres around the tracks
_FINEST = 2_000  # steps across the picture: finer vertices are left out


def add_world(
    block: ArrayBlock, frame: dict[str, float] | None, east: np.ndarray, north: np.ndarray, *, margin: float = 1.0
) -> bool:
    """Put the lines around the tracks in `block`, in the plan's metres; False where there are none.

    frame: of :func:`~jink.report.plan.plan_coordinates`. margin: what is shown around the tracks, as a share of
    their extent. Adds world_kind (L,) 0 coast, 1 border, 2 lake; world_first (L + 1,); world_x, world_y (V,).
    """
    known = np.isfinite(east) & np.isfinite(north)
    if frame is None or not known.any():
        return False
    low = np.array([east[known].min(), north[known].min()])
    high = np.array([east[known].max(), north[known].max()])
    around = max(margin * float((high - low).max()), _LEAST_MARGIN)
    kinds, lines = lines_within(frame, low - around, high + around)
    if not lines:
        return False
    block.add("world_kind", np.array(kinds), "u1")
    block.add("world_first", np.cumsum([0] + [len(line) for line in lines]), "i4")
    vertices = np.concatenate(lines)
    block.add("world_x", vertices[:, 0])
    block.add("world_y", vertices[:, 1])
    return True


def lines_within(frame: dict[str, float], low: np.ndarray, high: np.ndarray) -> tuple[list[int], list[np.ndarray]]:
    """(kinds, lines in metres) of the parts inside the box [low, high], one vertex beyond each end."""
    kind, first, degrees = _world()
    north = np.radians(degrees[:, 1] - frame["latitude"]) * frame["radius"]
    step = 2.0 ** np.floor(np.log2(float((high - low).max()) / _FINEST))
    kinds: list[int] = []
    lines: list[np.ndarray] = []
    for turn in (-360.0, 0.0, 360.0):
        east = np.radians(degrees[:, 0] + turn - frame["longitude"]) * frame["radius"]
        east *= np.cos(np.radians(frame["latitude"]))
        inside = (east >= low[0]) & (east <= high[0]) & (north >= low[1]) & (north <= high[1])
        for line in np.unique(np.searchsorted(first, np.flatnonzero(inside), side="right") - 1):
            a, b = first[line], first[line + 1]
            for part in _runs(inside[a:b]):
                metres = np.stack([east[a:b][part], north[a:b][part]], axis=1)
                kinds.append(int(kind[line]))
                lines.append(_coarser(metres, step))
    return kinds, lines


def _runs(inside: np.ndarray) -> list[slice]:
    """Stretches of rows inside, each with the row before and after it."""
    near = inside.copy()
    near[1:] |= inside[:-1]
    near[:-1] |= inside[1:]
    edges = np.flatnonzero(np.diff(near, prepend=False, append=False))
    return [slice(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a > 1]


def _coarser(metres: np.ndarray, step: float) -> np.ndarray:
    """The line without vertices in the same cell of a grid of `step` metres as the one before; its ends stay.

    Vertices lie on multiples of a quarter of `step`, a power of two: what is equal compresses.
    """
    cell = np.floor(metres / step)
    keep = np.ones(len(metres), dtype=bool)
    keep[1:-1] = (cell[1:-1] != cell[:-2]).any(axis=1)
    return np.round(metres[keep] / (step / 4.0)) * (step / 4.0)


def _world() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(kind (L,), first (L + 1,), longitude and latitude in degrees (V, 2)) of all lines."""
    with np.load(BytesIO((resources.files("jink.report") / "assets" / "world.npz").read_bytes())) as file:
        kind, first, start, step = (file[name] for name in ("kind", "first", "start", "step"))
    total = np.cumsum(step.T.astype(np.int64), axis=0)
    origin = start - total[first[:-1]]
    return kind, first, (total + np.repeat(origin, np.diff(first), axis=0)) * _UNIT
