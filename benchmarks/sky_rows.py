"""What is measured on whole skies, and what must be reached: the rows of `python -m benchmarks.skies`."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import inf

Limits = dict[str, tuple[float, float]]


@dataclass(frozen=True)
class Row:
    """One line of the table: a sky, what is believed of it, how many runs, and within what each figure must lie."""

    label: str
    sky: str
    runs: int
    limits: Limits = field(default_factory=dict)
    association: str = "marginal"
    clutter: float = 1.0  # believed, of the true one
    detection: float | None = None  # believed, where it is another than the true one
    against: str = ""  # label of the row whose GOSPA this one's is divided by


def most(**limits: float) -> Limits:
    """Figures that must not be larger; underscores are spaces."""
    return {name.replace("_", " "): (-inf, limit) for name, limit in limits.items()}


# tracks alive in the last third of the scans over those in the middle third
STEADY = most(growth=1.1)

MUST = [
    Row("A crossing", "sky-crossing", 1000, most(gospa=1.90)),
    Row("B four meet", "sky-four", 100, most(gospa=3.25)),
    Row("C 50 m", "sky-parallel-50", 100, most(gospa=99) | {"separation": (0.95, 1.4)}),
    Row("C 100 m", "sky-parallel", 100, most(gospa=101) | {"separation": (0.95, 1.15)}),
    Row("C 200 m", "sky-parallel-200", 100, most(gospa=97, swaps=0.25) | {"separation": (0.97, 1.03)}),
    Row("D 0.3 per km²", "sky-dense", 40, most(gospa=118, ids=2) | {"held": (0.85, inf)} | STEADY),
    Row("D 1 per km²", "sky-denser", 40, most(gospa=185) | STEADY),
    Row("E 200, 4 s", "sky-regional", 6, most(gospa=1900, switches=2, ms=0.4)),
    Row("E 200, 12 s", "sky-regional-200-12s", 6, most(gospa=2600, switches=15, ms=0.4)),
    Row("E 1000, 4 s", "sky-regional-1000-4s", 3, most(gospa=4450, switches=15, ms=2.5)),
    Row("E 1000, 12 s", "sky-regional-1000-12s", 3, most(gospa=6300, switches=100, ms=8)),
    Row("E 4000, 4 s", "sky-regional-4000-4s", 3, most(gospa=10_700, switches=80, ms=15, worst_ms=40) | STEADY),
    Row("E 4000, 12 s", "sky-regional-4000-12s", 3, most(gospa=16_300, switches=800, ms=90, worst_ms=300) | STEADY),
]
WRONG = [
    ("clutter × 3", {"clutter": 3.0}),
    ("clutter ÷ 3", {"clutter": 1 / 3}),
    *((f"Pd {p}", {"detection": p}) for p in (0.7, 0.98)),
]
OTHERS = ("gnn", "nearest", "pda", "jpda")


def rows(only: list[str], quick: bool) -> list[Row]:
    """What must be reached; wrong beliefs on B, C, D and E; the other rules on the same."""
    every = list(MUST)
    chosen = [row for row in MUST if row.label in ("B four meet", "C 100 m", "D 0.3 per km²", "E 200, 4 s")]
    for row in chosen:
        for label, wrong in WRONG:
            other = replace(row, label=f"{row.label}, {label}", limits=most(ratio=1.10), against=row.label)
            every.append(replace(other, **wrong))
    for row in chosen:
        runs = min(row.runs, 40)
        every += [replace(row, label=f"{row.label}, {how}", runs=runs, limits={}, association=how) for how in OTHERS]
    if quick:
        every = [replace(row, runs=max(2, row.runs // 10)) for row in every if "4000" not in row.sky]
    return [row for row in every if not only or any(row.label.startswith(o) for o in only)]
