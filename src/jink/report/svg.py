"""Drawings as SVG that takes its colours from the page, so that it is right in the light and in the dark."""

from __future__ import annotations

import math

import numpy as np

from ..checks import Array
from ..papers.drawing import Chart, Drawing, Line, Surface
from .shell import escape

WIDTH, HEIGHT = 560, 320
LEFT, RIGHT, TOP, BOTTOM = 66, 14, 10, 40
CELLS = 48  # of a surface, at most, either way


def drawn(drawing: Drawing) -> str:
    """A figure element: heading, picture, legend."""
    picture, legend = _surface(drawing) if isinstance(drawing, Surface) else _chart(drawing)
    return (
        f'<figure class="drawing"><figcaption>{escape(drawing.title)}</figcaption>'
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{escape(drawing.title)}">{picture}</svg>'
        f"{legend}{_in_words(drawing)}</figure>"
    )


def _in_words(drawing: Drawing) -> str:
    if not isinstance(drawing, Surface) or not drawing.sentences:
        return ""
    items = "".join(f"<li>{escape(line)}</li>" for line in drawing.sentences)
    return f"<details><summary>In words</summary><ul>{items}</ul></details>"


def ticks(low: float, high: float, about: int = 6) -> Array:
    """Round numbers between low and high."""
    raw = (high - low) / about
    magnitude = 10.0 ** math.floor(math.log10(raw))
    step = next(m for m in (1, 2, 5, 10) if m * magnitude >= raw) * magnitude
    return np.arange(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1, dtype=np.float64) * step


def log_ticks(low: float, high: float) -> Array:
    """1, 2 and 5 times powers of ten between low and high; the powers alone where that is enough."""
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    fine = np.array([m * 10.0**p for p in powers for m in ((1, 2, 5) if len(powers) < 5 else (1,))])
    return fine[(fine >= low * 0.999) & (fine <= high * 1.001)]


class Axes:
    """From numbers to places: x to the right, y upwards, linear or logarithmic."""

    def __init__(self, x: tuple[float, float], y: tuple[float, float], log: bool = False, square: bool = False):
        if square:
            x, y = _same_scale(x, y)
        self.x, self.y, self.log = x, y, log

    def across(self, x: Array) -> Array:
        return LEFT + (np.asarray(x) - self.x[0]) / (self.x[1] - self.x[0]) * (WIDTH - LEFT - RIGHT)

    def up(self, y: Array) -> Array:
        low, high = (math.log(v) for v in self.y) if self.log else self.y
        with np.errstate(divide="ignore", invalid="ignore"):
            value = np.log(y) if self.log else np.asarray(y)
        return HEIGHT - BOTTOM - (value - low) / (high - low) * (HEIGHT - TOP - BOTTOM)

    def frame(self, x_words: str, y_words: str) -> str:
        parts = []
        for t in log_ticks(*self.y) if self.log else ticks(*self.y):
            y = float(self.up(np.array(t)))
            parts.append(f'<line class="grid" x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y:.1f}" y2="{y:.1f}"/>')
            parts.append(f'<text x="{LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">{number(t)}</text>')
        for t in ticks(*self.x):
            x = float(self.across(np.array(t)))
            parts.append(f'<line class="grid" x1="{x:.1f}" x2="{x:.1f}" y1="{TOP}" y2="{HEIGHT - BOTTOM}"/>')
            parts.append(f'<text x="{x:.1f}" y="{HEIGHT - BOTTOM + 15}" text-anchor="middle">{number(t)}</text>')
        middle = (HEIGHT - BOTTOM + TOP) / 2
        parts.append(
            f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 6}" text-anchor="middle">{escape(x_words)}</text>'
        )
        parts.append(
            f'<text transform="translate(11 {middle}) rotate(-90)" text-anchor="middle">{escape(y_words)}</text>'
        )
        return "".join(parts)


def number(value: float) -> str:
    """A tick's label."""
    return f"{value:.6g}".replace("-", "−")


def _same_scale(x: tuple[float, float], y: tuple[float, float]) -> tuple[tuple[float, float], tuple[float, float]]:
    scale = max((x[1] - x[0]) / (WIDTH - LEFT - RIGHT), (y[1] - y[0]) / (HEIGHT - TOP - BOTTOM))
    widths = scale * (WIDTH - LEFT - RIGHT), scale * (HEIGHT - TOP - BOTTOM)
    middles = (x[0] + x[1]) / 2, (y[0] + y[1]) / 2
    return tuple((m - w / 2, m + w / 2) for m, w in zip(middles, widths, strict=True))  # type: ignore[return-value]


def _range(values: list[Array], log: bool, margin: float = 0.05) -> tuple[float, float]:
    joined = np.concatenate([v[np.isfinite(v) & ((v > 0) | (not log))] for v in values])
    if not len(joined):
        return (1.0, 10.0) if log else (0.0, 1.0)
    low, high = float(joined.min()), float(joined.max())
    if log:
        spread = max((high / low) ** margin, 1.02)
        return low / spread, high * spread
    extra = margin * (high - low) or 0.5
    return low - extra, high + extra


def _chart(chart: Chart) -> tuple[str, str]:
    xs, ys = ([np.asarray(getattr(line, c), dtype=float) for line in chart.lines] for c in "xy")
    x = _range(xs, log=False, margin=0.05 if chart.square else 0.0)
    y = _range(ys, chart.log)
    log = chart.log and y[1] > 5 * y[0]
    if not log and not chart.square and 0 < y[0] < 0.4 * y[1]:
        y = (0.0, y[1])  # errors are lengths: seen from zero
    axes = Axes(x, y, log, chart.square)
    shaded = "".join(
        f'<rect class="shaded" x="{a:.1f}" width="{b - a:.1f}" y="{TOP}" height="{HEIGHT - TOP - BOTTOM}"/>'
        for a, b in (np.clip(axes.across(np.array(span)), LEFT, WIDTH - RIGHT) for span in chart.shaded)
    )
    colours = _colours(chart.lines)
    order = sorted(range(len(chart.lines)), key=lambda i: not chart.lines[i].faint)
    lines = "".join(_line(axes, chart.lines[i], colours[i], xs[i], ys[i]) for i in order)
    keys = "".join(
        f'<span class="key {colour}">{escape(line.label)}</span>'
        for line, colour in zip(chart.lines, colours, strict=True)
        if line.label
    )
    return shaded + axes.frame(chart.x, chart.y) + lines, f'<p class="keys">{keys}</p>' if keys else ""


def _colours(lines: object) -> list[str]:
    """A class per line: the paper's filters in strong colours, the others faint."""
    counts = {True: 0, False: 0}
    found = []
    for line in lines:  # type: ignore[attr-defined]
        found.append(f"{'f' if line.faint else 's'}{counts[line.faint] % 6}")
        counts[line.faint] += 1
    return found


def _line(axes: Axes, line: Line, colour: str, x: Array, y: Array) -> str:
    px, py = axes.across(x), axes.up(y)
    there = np.isfinite(px) & np.isfinite(py)
    if line.marks:
        points = "".join(f"M{a:.1f} {b:.1f}h0" for a, b in zip(px[there], py[there], strict=True))
        return f'<path class="marks {colour}" d="{points}"/>'
    path, pen = [], "M"
    for a, b, ok in zip(px, py, there, strict=True):
        if ok:
            path.append(f"{pen}{a:.1f} {b:.1f}")
        pen = "L" if ok else "M"
    return f'<path class="line {colour}" d="{"".join(path)}"/>'


def _surface(surface: Surface) -> tuple[str, str]:
    x, y, values = (np.asarray(a, dtype=float) for a in (surface.grid_x, surface.grid_y, surface.values))
    across, down = (max(1, math.ceil(len(grid) / CELLS)) for grid in (x, y))
    x, y, values = x[::across], y[::down], values[::down, ::across]
    axes = Axes((x[0], x[-1]), (y[0], y[-1]))
    low, high = float(values.min()), float(values.max())
    share = (values - low) / (high - low) if high > low else np.zeros_like(values)
    width = (WIDTH - LEFT - RIGHT) / len(x)
    height = (HEIGHT - TOP - BOTTOM) / len(y)
    cells = "".join(
        f'<rect class="cell" x="{LEFT + i * width:.2f}" y="{HEIGHT - BOTTOM - (j + 1) * height:.2f}" '
        f'width="{width + 0.3:.2f}" height="{height + 0.3:.2f}" style="--share:{100 * share[j, i]:.0f}%"/>'
        for j in range(len(y))
        for i in range(len(x))
    )
    scale = f'<p class="scale"><span>{low:.3g}</span><i></i><span>{high:.3g} {escape(surface.unit)}</span></p>'
    return f'<g shape-rendering="crispEdges">{cells}</g>' + axes.frame(surface.x, surface.y), scale
