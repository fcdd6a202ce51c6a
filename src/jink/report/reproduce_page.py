"""Papers reproduced, as one page: published beside measured, their figures redrawn, what they leave open."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence

from ..papers.run import Outcome
from .papers_table import Sheet, measured, published, sheets
from .shell import escape, plain_page, version, write_page
from .svg import drawn


def write(outcomes: Sequence[Outcome], path: str | os.PathLike[str]) -> None:
    """Write the page of these outcomes to path, at once or not at all."""
    write_page(path, page(outcomes))


def page(outcomes: Sequence[Outcome]) -> str:
    """The HTML text; it needs no scripts and nothing from elsewhere."""
    return joined({outcome.paper.name: section(outcome) for outcome in outcomes})


def joined(sections: Mapping[str, str]) -> str:
    """The same of sections by the names of their papers."""
    names = ", ".join(sections)
    links = "".join(f'<a href="#{name}">{escape(name)}</a>' for name in sections)
    contents = f'<nav class="contents" aria-label="Papers">{links}</nav>' if len(sections) > 1 else ""
    head = (
        '<header class="masthead centred"><div class="names"><h1>Published beside measured</h1>'
        f'<p class="lede">{escape(names)} · jink {escape(version())}</p></div></header>'
    )
    body = head + contents + "".join(sections.values())
    return plain_page(title=f"Reproduced: {names}", body=body, style="reproduce.css")


def section(outcome: Outcome) -> str:
    """What the page says of one paper."""
    paper = outcome.paper
    partial = " Interrupted, so only some of the runs are counted." if outcome.partial else ""
    tables = "".join(_sheet(sheet) for sheet in sheets(outcome))
    drawings = "" if outcome.partial else "".join(drawn(d) for d in paper.draw(outcome.races))
    figures = f'<h3>Figures redrawn</h3><div class="drawings">{drawings}</div>' if drawings else ""
    return (
        f'<section class="paper" id="{paper.name}"><h2>{escape(paper.name)}</h2>'
        f'<p class="lede">{escape(paper.source)}. {outcome.runs:,} runs, seed {outcome.seed}.{partial}</p>'
        f'<div class="sheets">{tables}</div>{figures}'
        f"{_list('What the paper leaves open, and the reading taken', paper.readings)}"
        f"{_list('Remarks', paper.remarks)}</section>"
    )


def _list(title: str, items: Sequence[str]) -> str:
    return f"<h3>{title}</h3><ul>{''.join(f'<li>{escape(i)}</li>' for i in items)}</ul>" if items else ""


def _sheet(sheet: Sheet) -> str:
    head = '<th scope="col">filter</th>'
    for metric, known in sheet.columns:
        head += '<th scope="col">published</th>' if known else ""
        head += f'<th scope="col">{escape(metric.words)}</th>'
    body = ""
    for line in sheet.lines:
        cells = f'<th scope="row" title="{escape(line.words)}">{escape(line.label)}</th>'
        for metric, known in sheet.columns:
            row = line.rows.get(metric.name)
            if known:
                cells += f'<td class="published">{published(row)}</td>'
            value, _, error = measured(row).partition(" ")
            cells += f"<td>{value} <small>{error}</small></td>"
        body += f'<tr class="{"beside" if line.beside else "own"}">{cells}</tr>'
    notes = "; ".join(sheet.notes)
    return (
        f'<section><h3>{escape(sheet.title)}</h3><div class="sheet">'
        f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
        + (f'<p class="note">{escape(notes)}</p>' if notes else "")
        + "</div></section>"
    )
