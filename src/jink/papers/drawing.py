"""Drawings for pages: lines over an axis and surfaces, as data; :mod:`jink.report.svg` draws them."""

from __future__ import annotations

from collections.abc import Sequence

from numpy.typing import ArrayLike

from ..frozen import frozen


@frozen
class Line:
    """One line: x and y (n,), NaN where it breaks; faint for what is there to compare with; marks: points, no line."""

    label: str
    x: ArrayLike
    y: ArrayLike
    faint: bool = False
    marks: bool = False


@frozen(kw_only=True)
class Chart:
    """Lines over common axes.

    log: a logarithmic y axis where values spread enough; square: the same scale both ways; spans of x that are shaded.
    """

    title: str
    x: str
    y: str
    lines: Sequence[Line]
    log: bool = False
    square: bool = False
    shaded: Sequence[tuple[float, float]] = ()


@frozen(kw_only=True)
class Surface:
    """values (rows y, columns x) over the grids x and y, coloured from the least to the largest; unit of the values."""

    title: str
    x: str
    y: str
    grid_x: ArrayLike
    grid_y: ArrayLike
    values: ArrayLike
    unit: str
    sentences: Sequence[str] = ()  # the same in words


Drawing = Chart | Surface
