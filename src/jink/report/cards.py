"""The cards below the tracks: consistency, and what the run has to say of its input, cleaning and filter."""

import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

from .consistency import BINS, Consistency
from .shell import escape

_MOMENT = re.compile(r"(\d{4}-\d\d-\d\d)[T ](\d\d:\d\d:\d\d)(?:\.\d+)?(?:\+00:00|Z)")
_LINE = 24  # characters of a name that stay on one line
_VALUE = 16  # characters of a value that do
_SHORT = 60  # characters: a list that reads as one value
_COMPUTED = "consistency"  # the page computes this from the tracks and shows more of it


def summary_cards(summary: Mapping[str, Any]) -> str:
    """One card for all the plain values, then one per key whose value is a mapping or a longer list."""
    shown = {key: value for key, value in summary.items() if key != _COMPUTED or not isinstance(value, Mapping)}
    plain = {key: value for key, value in shown.items() if not isinstance(value, Mapping) and not _is_long(value)}
    cards = [_card("Run", _pairs(plain))] if plain else []
    cards += [_card(_words(key), _content(value)) for key, value in shown.items() if key not in plain]
    return "\n".join(cards)


def _is_long(value: Any) -> bool:
    if not isinstance(value, list | tuple):
        return False
    return any(isinstance(item, Mapping) for item in value) or len(_text(value)) > _SHORT


def _card(title: str, content: str) -> str:
    heading = escape(title[:1].upper() + title[1:])
    return f'<section class="card"><h3>{heading}</h3>{content}</section>'


def _content(value: Any) -> str:
    if isinstance(value, Mapping):
        return _pairs(value)
    if _is_records(value):
        return _pairs(value[0]) if len(value) == 1 else _records(value)
    items = "".join(f"<li>{escape(_text(item))}</li>" for item in value)
    return f"<ul>{items}</ul>" if items else "<p>none</p>"


def _pairs(values: Mapping[Any, Any]) -> str:
    """Names and values; a mapping or list of mappings inside becomes a table with a heading of its own."""
    rows, below = [], []
    for key, value in values.items():
        if (isinstance(value, Mapping) and value) or _is_records(value):
            below.append(f"<h4>{escape(_words(key))}</h4>{_content(value)}")
            continue
        if isinstance(value, list | tuple):
            value = ", ".join(_text(item) for item in value) or "none"
        name, text = _words(key), _text(value)
        kinds = [*(["zero"] if _is_nothing(value) else []), *(["short"] if len(text) <= _VALUE else [])]
        short = ' class="short"' if len(name) <= _LINE else ""
        cell = f'<td class="{" ".join(kinds)}">{escape(text)}</td>'
        rows.append(f'<tr><th scope="row"{short}>{escape(name)}</th>{cell}</tr>')
    table = f"<table><tbody>{''.join(rows)}</tbody></table>" if rows else ""
    return (table + "".join(below)) or "<p>none</p>"


def _is_nothing(value: Any) -> bool:
    return value is None or (isinstance(value, int | float) and not isinstance(value, bool) and value == 0)


def _is_records(value: Any) -> bool:
    return isinstance(value, list | tuple) and bool(value) and all(isinstance(item, Mapping) for item in value)


def _records(items: Sequence[Mapping[str, Any]]) -> str:
    names = list(dict.fromkeys(name for item in items for name in item))
    head = "".join(f'<th scope="col">{escape(_words(name))}</th>' for name in names)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(_text(item.get(name)))}</td>" for name in names) + "</tr>" for item in items
    )
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _words(name: object) -> str:
    return str(name).replace("_", " ")


def _text(value: Any) -> str:
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return group(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            return "–"
        return group(int(value)) if value.is_integer() and abs(value) < 1e15 else f"{value:.4g}"
    if isinstance(value, Mapping):
        return ", ".join(f"{_words(k)} {_text(v)}" for k, v in value.items())
    if isinstance(value, list | tuple):
        return ", ".join(_text(item) for item in value)
    text = str(value)
    moment = _MOMENT.fullmatch(text)
    return f"{moment[1]} {moment[2]} UTC" if moment else text


def group(number: int) -> str:
    """Thousands set apart by narrow spaces."""
    return f"{number:,}".replace(",", "\u202f")


def consistency_card(check: Consistency, gated: int) -> str:
    """Share of NIS inside its band, the shares on either side, and the histogram of F(NIS)."""
    n = int(check.compared.sum())
    if n == 0:
        return _card("Consistency", "<p>These tracks have no NIS, so there is nothing to compare.</p>")
    inside, below, above = (int(v.sum()) / n for v in (check.inside, check.below, check.above))
    table = _pairs(
        {
            "Below it (expected 2.5 %)": _percent(below),
            "Above it (expected 2.5 %)": _percent(above),
            "Mean NIS / dof (expected 1)": f"{check.mean_ratio:.3g}",
            "Rows compared": n,
            "Rows gated, not compared": gated,
        }
    )
    share = f'<p class="big" id="nis-overall">{_percent(inside)} <small>of NIS inside the 95 % band</small></p>'
    note = (
        '<p class="note">Where the bars are level with the dashed line, errors are as large as the filter believes. '
        "Higher bars on the right mean larger errors, on the left smaller ones. With several modes the NIS is that of "
        "their combined innovation; then chi-square is a guide, not an exact law.</p>"
    )
    figure = f"<h4>Where NIS falls in its chi-square distribution</h4>{_histogram(check)}"
    return _card("Consistency", share + table + figure + note)


def _percent(share: float) -> str:
    return f"{100 * share:.1f} %"


def _histogram(check: Consistency) -> str:
    """SVG bars of F(NIS) in BINS equal bins with the level expected of a consistent filter."""
    width, height, base = 280, 118, 100
    counts = check.histogram / max(check.histogram.mean(), 1e-12)
    scale = (base - 8) / max(float(counts.max()), 1.5)
    bar = width / BINS
    bars = "".join(
        f'<rect x="{i * bar + 1:.1f}" y="{base - h:.1f}" width="{bar - 2:.1f}" height="{h:.1f}"/>'
        for i, h in enumerate(counts * scale)
    )
    level = base - scale
    label = escape("Bars: " + ", ".join(f"{c:.2f}" for c in counts) + " times the expected count")
    return (
        f'<svg class="histogram" viewBox="0 0 {width} {height}" role="img" aria-label="{label}">{bars}'
        f'<line x1="0" x2="{width}" y1="{level:.1f}" y2="{level:.1f}"/>'
        f'<text x="0" y="{height - 6}">0 (small NIS)</text>'
        f'<text x="{width}" y="{height - 6}" text-anchor="end">1 (large NIS)</text></svg>'
    )
