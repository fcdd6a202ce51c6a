"""Small charts as SVG text, for pages that need no script."""

import numpy as np

from ..checks import Array
from ..frozen import frozen
from .shell import escape

WIDTH, HEIGHT, LEFT, BOTTOM, TOP = 560, 150, 46, 18, 16
POINTS = 600  # at most on one line


@frozen
class Line:
    """A named line; colour is a variable of the style sheet."""

    name: str
    values: Array
    colour: str


def lines(time: Array, drawn: list[Line], title: str, top: float | None = None) -> str:
    """Lines over time from zero (or the smallest value, if below) to the largest (without the largest hundredth), named
    above.
    """
    every = np.concatenate([line.values for line in drawn])
    every = every[np.isfinite(every)]
    high = top or (1.15 * float(np.quantile(every, 0.99)) if every.size else 1.0) or 1.0
    low = min(0.0, float(every.min())) if every.size else 0.0
    first, last = float(time[0]), max(float(time[-1]), float(time[0]) + 1e-9)
    parts = [_frame(low, high, first, last), _names(drawn, title)]
    for line in drawn:
        points = " ".join(
            f"{_x(t, first, last):.1f},{_y(min(v, high), low, high):.1f}" for t, v in _thinned(time, line.values)
        )
        style = f"fill:none;stroke:var(--{line.colour});stroke-width:1.2"
        parts.append(f'<polyline points="{points}" style="{style}"/>')
    return _svg(parts, title)


def bars(values: Array, title: str, level: float | None = None) -> str:
    """Bars from zero up and down, in the order given; a dashed line at a level they should reach."""
    if not len(values):
        return "<p>nothing to show</p>"
    high, low = max(float(values.max()), 0.0), min(float(values.min()), 0.0)
    span = (high - low) or 1.0
    zero, room = TOP + (HEIGHT - TOP - BOTTOM) * high / span, HEIGHT - TOP - BOTTOM
    width = (WIDTH - LEFT) / len(values)
    parts = [
        f'<line x1="{LEFT}" x2="{WIDTH}" y1="{zero:.1f}" y2="{zero:.1f}" style="stroke:var(--muted)"/>',
        _text(0, TOP + 4, _short(high)),
        _text(0, HEIGHT - BOTTOM, _short(low)),
        _text(LEFT, 10, title),
    ]
    for k, value in enumerate(values):
        height = abs(float(value)) / span * room
        y = zero - height if value > 0 else zero
        colour = "accent" if value > 0 else "second"
        box = f'x="{LEFT + k * width:.1f}" y="{y:.1f}" width="{max(width - 1, 0.8):.1f}" height="{height:.1f}"'
        parts.append(f'<rect {box} style="fill:var(--{colour})"/>')
    if level is not None:
        y = zero - level / span * room
        style = "stroke:var(--ink);stroke-dasharray:4 3"
        parts.append(f'<line x1="{LEFT}" x2="{WIDTH}" y1="{y:.1f}" y2="{y:.1f}" style="{style}"/>')
    return _svg(parts, title)


def _thinned(time: Array, values: Array) -> list[tuple[float, float]]:
    """At most so many points, of each piece the largest."""
    there = np.flatnonzero(np.isfinite(values))
    pieces = np.array_split(there, min(POINTS, len(there))) if there.size else []
    kept = [int(piece[np.argmax(values[piece])]) for piece in pieces]
    return [(float(time[k]), float(values[k])) for k in kept]


def _short(value: float) -> str:
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.2g}"


def _x(t: float, first: float, last: float) -> float:
    return LEFT + (WIDTH - LEFT - 2) * (t - first) / (last - first)


def _y(value: float, low: float, high: float) -> float:
    return HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * (value - low) / ((high - low) or 1.0)


def _frame(low: float, high: float, first: float, last: float) -> str:
    base, zero = HEIGHT - BOTTOM, _y(0.0, low, high)
    return (
        f'<line x1="{LEFT}" x2="{WIDTH}" y1="{zero:.1f}" y2="{zero:.1f}" style="stroke:var(--line)"/>'
        + _text(0, TOP + 6, _short(high))
        + _text(0, base, _short(low))
        + _text(LEFT, HEIGHT - 4, f"{first:.0f} s")
        + _text(WIDTH, HEIGHT - 4, f"{last:.0f} s", "end")
    )


def _names(drawn: list[Line], title: str) -> str:
    keys = "".join(f'<tspan dx="10" style="fill:var(--{line.colour})">{escape(line.name)}</tspan>' for line in drawn)
    return f'<text x="{LEFT}" y="10" style="fill:var(--muted);font-size:11px">{escape(title)}{keys}</text>'


def _text(x: float, y: float, words: str, anchor: str = "start") -> str:
    style = "fill:var(--muted);font-size:11px"
    return f'<text x="{x}" y="{y:.1f}" text-anchor="{anchor}" style="{style}">{escape(words)}</text>'


def _svg(parts: list[str], title: str) -> str:
    box = f'viewBox="0 0 {WIDTH} {HEIGHT}" width="100%" role="img" aria-label="{escape(title)}"'
    return f"<svg {box}>{''.join(parts)}</svg>"
