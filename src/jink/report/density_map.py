"""The map of a folder of tracks: rows per cell over coasts and borders, as SVG in the colours of the page."""

from __future__ import annotations

import numpy as np

from .cards import group
from .picture import mask, shaded
from .survey import Survey
from .svg import HEIGHT, WIDTH, Axes
from .world import lines_within

_KILOMETRE = 1_000.0


def density_map(found: Survey) -> str:
    """A figure element."""
    extent = found.extent
    east, north = (tuple(side / _KILOMETRE for side in sides) for sides in (extent.east, extent.north))
    axes = Axes(east, north, square=True)  # type: ignore[arg-type]
    left, right = (float(axes.across(np.array(side))) for side in east)
    bottom, top = (float(axes.up(np.array(side))) for side in north)
    box = f'x="{left:.1f}" y="{top:.1f}" width="{right - left:.1f}" height="{bottom - top:.1f}"'
    picture = mask(shaded(found.density)[::-1])
    words = ("km east", "km north")
    if extent.frame is not None:
        place = f"{extent.frame['latitude']:.2f}°, {extent.frame['longitude']:.2f}°"
        words = (f"km east of {place}", "km north")
    outside = f" {group(found.outside)} rows are outside." if found.outside else ""
    return (
        '<figure class="drawing"><figcaption>Where the targets were</figcaption>'
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="Map of the rows">'
        f"{axes.frame(*words)}{_coasts(found, axes)}"
        f'<mask id="rows"><image href="{picture}" {box} preserveAspectRatio="none"/></mask>'
        f'<rect class="density" mask="url(#rows)" {box}/></svg>'
        f'<p class="note">Darker where more rows are, by rank of the cells.{outside}</p></figure>'
    )


def _coasts(found: Survey, axes: Axes) -> str:
    """Coasts, borders and lakes inside the picture."""
    extent = found.extent
    if extent.frame is None:
        return ""
    low, high = (np.array([extent.east[side], extent.north[side]]) for side in (0, 1))
    paths = []
    for line in lines_within(extent.frame, low, high)[1]:
        inside = np.clip(line, low, high) / _KILOMETRE
        x, y = axes.across(inside[:, 0]), axes.up(inside[:, 1])
        paths.append("M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(x, y, strict=True)))
    return f'<path class="coast" d="{"".join(paths)}"/>' if paths else ""
