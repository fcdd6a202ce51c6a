"""What jink has promised of its adaptive filters' speed, and what choosing modes costs in accuracy: rows of the
report.
"""

from __future__ import annotations

from typing import Any

from .adaptive import CONTESTS, Contest
from .race import Lap, compare
from .structure import ALL, BEST, JUMPS, METHODS
from .targets import Row, reason, times

LEAST, SAME = (
    4,
    0.02,
)  # how many times faster than all forty modes, with a position RMSE that differs by no more than this share
PROMISED = ("active digraph, 3 alive", "adaptive grid")  # of the methods that choose modes, those held to it


def rows(results: dict[str, Any]) -> list[Row]:
    """Every contest, then speed and accuracy of the variable structures."""
    return [*(_contest(results, each) for each in CONTESTS), *_slow_rows(results), _jump_row(results)]


def _contest(results: dict[str, Any], contest: Contest) -> Row:
    costs = results.get("adaptive", {})
    what, must = f"{contest.name}, against {contest.against}", f"≤ {contest.limit:g} ×"
    if contest.name not in costs or contest.against not in costs:
        return Row(what, reason(results, "adaptive"), must)
    lap = Lap(tuple(costs[contest.name]))
    ratio = compare(lap, Lap(tuple(costs[contest.against])))
    return Row(what, f"{lap.median * 1e9:.1f} ns; {times(ratio)}", must, ratio.median <= contest.limit)


def _slow_rows(results: dict[str, Any]) -> list[Row]:
    structure = results.get("structure", {})
    out = []
    for name in METHODS:
        if name == ALL:
            continue
        what = f"{name}, against an IMM of all 40 modes, level slowly changing"
        must = f"≥ {LEAST} × as fast, RMSE ± {SAME:.0%}" if name in PROMISED else ""
        if "costs" not in structure:
            out.append(Row(what, reason(results, "structure"), must))
            continue
        all_forty, this = (Lap(tuple(structure["costs"][key])) for key in (ALL, name))
        ratio, rms = compare(all_forty, this), structure["rms"]["slow"]
        share = rms[name][0] / rms[ALL][0] - 1
        words = f"{times(ratio)} as fast; RMSE {share:+.1%} ({_figures(rms, name)})"
        out.append(Row(what, words, must, ratio.median >= LEAST and abs(share) <= SAME if must else None))
    return out


def _jump_row(results: dict[str, Any]) -> Row:
    what = "digraph switching against that IMM on choi-2001's scenarios 1–4, position RMSE"
    structure = results.get("structure", {})
    if "rms" not in structure:
        return Row(what, reason(results, "structure"))
    keys = ("digraph switching", ALL, "raw")
    figures = [[structure["rms"][name][key][0] for key in keys] for name in JUMPS]
    return Row(what, "; ".join(f"{mine:.2f} against {whole:.2f} (raw {raw:.2f}) m" for mine, whole, raw in figures))


def _figures(rms: dict[str, list[float]], name: str) -> str:
    value, se = rms[name]
    return f"{value:.2f} ± {se:.2f} m; IMM {rms[ALL][0]:.2f}, best level {rms[BEST][0]:.2f}"
