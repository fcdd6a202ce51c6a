"""The page of `jink fit --report`: held-out tracks before and after, parameters, verdicts."""

import os
from collections.abc import Sequence

import numpy as np

from ..checks import Array
from ..estimate import Status
from ..fit.regimes import innovations, measures_positions
from ..fit.result import FITTED, START, Fit
from ..fit.search import Search
from .arrays import ArrayBlock
from .consistency import Consistency, consistency
from .fit_charts import Line, bars, lines
from .fit_table import heading, interval, number, part_rows, verdict
from .search_table import heading as heading_of_search
from .search_table import table as search_table
from .shell import escape, page, write_page

WIDE = "column-span: all"  # of a card over all columns
SHOWN = 3  # tracks drawn in full: most gained, middle, most lost
AROUND = 31  # rows that innovations are averaged over
PARTS = (
    "<p>Share of held-out NIS inside its 95 % band, ± standard error over targets. A consistent filter has 90 to "
    "98 %. The positions around a row decide to which part it belongs. Repeated readings are left out.</p>"
)


def write_fit_report(fit: Fit, path: str | os.PathLike[str], search: Search | None = None) -> None:
    """Write one HTML file that needs no network, no script and no other file; with the search that the fit is the best
    of.
    """
    title = f"{fit.name}, fitted"
    before, after = (_Followed(f, fit) for f in (fit.start, fit.filter))
    gain = after.score - before.score
    order = np.argsort(-np.nan_to_num(gain, nan=-np.inf), kind="stable")
    counted = [int(b) for b in order if np.isfinite(gain[b])]
    chosen = list(dict.fromkeys(counted[i] for i in (0, len(counted) // 2, -1))) if counted else []
    body = [
        f'<header class="masthead"><div class="names"><h1>{escape(title)}</h1>',
        *(f'<p class="lede">{escape(line)}</p>' for line in heading(fit).splitlines()),
        "</div></header><main class='cards' style='columns: 420px'>",
        "" if search is None else _card("Candidates", _candidates(search), WIDE),
        _verdict_card(fit),
    ]
    if rows := part_rows(fit):
        table = _table(["NIS inside", "rows", "before", "after"], rows)
        body.append(_card("Consistency by part of the tracks", PARTS + table))
    body += [
        _card("Parameters", _parameters(fit)),
        _card("Held-out tracks: log-likelihood per plot, after − before", bars(gain[counted], "nats per plot")),
    ]
    body += [_card(_name(fit, b, k, len(chosen)), _track(before, after, b)) for k, b in enumerate(chosen)]
    body += [_card(f"Consistency {word}", _histogram(f.check)) for word, f in (("before", before), ("after", after))]
    body.append("</main>")
    write_page(path, page(title=title, body="\n".join(body), scripts=(), meta={}, block=ArrayBlock()))


class _Followed:
    """The held-out tracks as one filter sees them."""

    def __init__(self, filter: object, fit: Fit) -> None:
        tracks = fit.held_out
        wanted = ("x", "mode_probability", "log_likelihood_scan", "nis", "nis_dof", "status")
        est = filter.filter(**tracks.keywords(), outputs=wanted)  # type: ignore[attr-defined]
        self.tracks = tracks
        owner = np.repeat(np.arange(len(tracks)), np.diff(tracks.offsets))
        scored = est.scored & (np.ones(tracks.rows, bool) if tracks.counts is None else tracks.counts)
        count = np.bincount(owner, scored, len(tracks))
        with np.errstate(invalid="ignore"):
            self.score = np.bincount(owner, np.where(scored, est.log_likelihood_scan, 0.0), len(tracks)) / count
        nis, dof, status = est.nis, est.nis_dof, est.status
        if measures_positions(filter):
            nis, dof = innovations(filter, tracks)
            status = np.where(dof > 0, Status.updated, Status.none)
        self.check = consistency(owner, len(tracks), nis, dof, (status == Status.updated) & scored)
        self.manoeuvring = est.manoeuvring if any(est.non_manoeuvring) else None
        self.error = _errors(est, tracks.truth, tracks.components) if tracks.truth is not None else None
        believed = scored & (est.status == Status.updated)  # what is gated is not believed
        self.ratio = np.where(believed, nis / np.maximum(dof, 1), np.nan)
        self.density = np.where(scored, est.log_likelihood_scan, 0.0)

    def rows(self, b: int) -> slice:
        return slice(int(self.tracks.offsets[b]), int(self.tracks.offsets[b + 1]))


def _errors(est: object, truth: Array, components: Sequence[str]) -> Array:
    places = [k for k, name in enumerate(components) if name[0] == "p"]
    found = np.stack([est[components[k]] for k in places], axis=1)  # type: ignore[index]
    return np.sqrt(((found - truth[:, places]) ** 2).sum(axis=1))


def _track(before: _Followed, after: _Followed, b: int) -> str:
    """The error (or the innovations over their sd) and the probability of manoeuvring along one track."""
    rows = before.rows(b)
    time = before.tracks.time[rows]
    if before.error is not None and after.error is not None:
        upper = [Line("before", before.error[rows], "second"), Line("after", after.error[rows], "accent")]
        drawn = lines(time, upper, "position error, m")
    else:
        upper = [
            Line("before", _smooth(before.ratio[rows]), "second"),
            Line("after", _smooth(after.ratio[rows]), "accent"),
        ]
        drawn = lines(time, upper, f"innovations over their sd (rms of {AROUND} rows; 1 is expected)")
        gained = np.cumsum(after.density[rows] - before.density[rows])
        drawn += lines(time, [Line("after − before", gained, "accent")], "log-likelihood gained so far")
    lower = [
        Line(word, followed.manoeuvring[rows], colour)
        for word, followed, colour in (("before", before, "second"), ("after", after, "accent"))
        if followed.manoeuvring is not None
    ]
    if lower:
        drawn += lines(time, lower, "probability of manoeuvring", top=1.0)
    return drawn


def _smooth(ratio: Array) -> Array:
    """Root of the mean of NIS / components over the rows around each."""
    there = np.isfinite(ratio)
    kernel = np.ones(min(AROUND, len(ratio)))
    total, count = (np.convolve(a, kernel, "same") for a in (np.where(there, ratio, 0.0), there.astype(float)))
    return np.where(count > 0, np.sqrt(total / np.maximum(count, 1.0)), np.nan)


def _name(fit: Fit, b: int, place: int, shown: int) -> str:
    word = ("gained most", "in the middle", "gained least")[place if shown == SHOWN else 0]
    owner = fit.held_out.owner
    which = b if owner is None else owner[b]
    return f"Held-out track {which}: {word}"


def _verdict_card(fit: Fit) -> str:
    items = "".join(f"<li>{escape(line)}</li>" for line in fit.verdicts())
    said = "".join(f'<p class="note">Warning: {escape(line)}</p>' for line in fit.warnings)
    race = fit.race
    rows = []
    for metric in dict.fromkeys([*fit.judged, *race.compared, "nis_inside"]):
        found = [race.figure(name, metric).value for name in (START, FITTED)]
        if np.isfinite(found).all():
            rows.append([metric.replace("_", " "), *(f"{value:.4g}" for value in found)])
    table = _table(["", "before", "after"], rows)
    return _card(verdict(fit), f"{table}<h4>Paired 95% intervals of the difference</h4><ul>{items}</ul>{said}")


def _parameters(fit: Fit) -> str:
    rows = [
        [
            r["parameter"].replace(".", " · "),
            number(r["before"]),
            number(r["after"]),
            interval(r["low"], r["high"]),
        ]
        for r in fit.table()
    ]
    return _table(["SI units", "before", "after", "95% interval"], rows)


def _candidates(search: Search) -> str:
    head, rows = search_table(search)
    said = f"<ul>{''.join(f'<li>{escape(line)}</li>' for line in search.explanation)}</ul>"
    left = "".join(f'<p class="note">Without {escape(name)}: {escape(why)}</p>' for name, why in search.left.items())
    return f"{said}<p>{escape(heading_of_search(search))}</p>{_table(head, rows)}{left}"


def _histogram(check: Consistency) -> str:
    n = int(check.compared.sum())
    if not n:
        return "<p>These tracks have no NIS, so there is nothing to compare.</p>"
    share = 100 * int(check.inside.sum()) / n
    counts = check.histogram / max(check.histogram.mean(), 1e-12)
    words = (
        f"<p>{share:.1f} % of NIS lie inside the 95 % band. Where the bars are level with 1, errors are as large as "
        "the filter believes.</p>"
    )
    return words + bars(counts, "times the expected count", level=1.0)


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    top = "".join(f'<th scope="col">{escape(name)}</th>' for name in head)
    whole = ' style="white-space:nowrap"'
    body = "".join(
        "<tr>" + "".join(f"<td{whole if k else ''}>{escape(cell)}</td>" for k, cell in enumerate(row)) + "</tr>"
        for row in rows
    )
    return f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"


def _card(title: str, content: str, style: str = "") -> str:
    return f'<section class="card" style="{style}"><h3>{escape(title)}</h3>{content}</section>'
