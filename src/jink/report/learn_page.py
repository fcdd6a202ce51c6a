"""The page of `jink learn --report`: figures on held-out data, what was learned as drawings and as sentences."""

from __future__ import annotations

import os

from ..learn.learning import LEARNED, Learned
from .learn_table import heading
from .learned_pictures import pictures
from .race_table import COLUMNS, footnotes, label, ordered, written
from .shell import escape, plain_page, version, write_page
from .svg import drawn


def write_learn_report(learned: Learned, path: str | os.PathLike[str]) -> None:
    """Write one HTML file that needs no network, no script and no other file."""
    title = f"{learned.name}, learned"
    drawings = "".join(drawn(each) for each in pictures(learned.filter))
    said = "".join(f"<li>against {escape(n)}: {escape(s)}</li>" for n, s in learned.verdicts().items())
    warned = "".join(f'<p class="note">Warning: {escape(line)}</p>' for line in learned.warnings)
    body = (
        f'<header class="masthead centred"><div class="names"><h1>{escape(title)}</h1>'
        f'<p class="lede">{escape(heading(learned))} · jink {escape(version())}</p></div></header>'
        f'<section class="paper"><h2>{escape(learned.verdict())}</h2>'
        f'<div class="sheets">{_table(learned)}</div><ul>{said}</ul>{warned}'
        f'<h3>What was learned</h3><div class="drawings">{drawings}</div></section>'
    )
    write_page(path, plain_page(title=title, body=body, style="reproduce.css"))


def _table(learned: Learned) -> str:
    race = learned.race
    figures = {name: race.figures(name) for name in race.tallies}
    columns = [c for c in COLUMNS if c in race.metrics and any(c in found for found in figures.values())]
    head = "".join(f'<th scope="col">{escape(COLUMNS[c])}</th>' for c in columns)
    rows = ""
    for name in ordered(race):
        cells = "".join(f"<td>{escape(written(c, figures[name].get(c)))}</td>" for c in columns)
        words = escape(race.entrants[name].words)
        rows += (
            f'<tr class="{"own" if name == LEARNED else "beside"}"><th scope="row" title="{words}">'
            f"{escape(label(race, name))}</th>{cells}</tr>"
        )
    head = f'<th scope="col">filter</th>{head}'
    seen = f", seen by {race.seen}" if race.seen else ""
    notes = "".join(f'<p class="note">{escape(line)}</p>' for line in footnotes(race))
    return (
        f"<section><h3>{escape(race.scenario)}: {race.runs:,} {escape(race.unit)} held out, seed {race.seed}"
        f"{escape(seen)}</h3>"
        f'<div class="sheet"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>{notes}</section>'
    )
