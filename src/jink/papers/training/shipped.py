"""The models that come with the package: how each was trained, and the files they are in."""

from __future__ import annotations

from typing import Any

from ...checks import unknown
from ...learn.recipes import ANFIS, NETWORK
from . import aimm, choi_2001, correctors, lee, titi_guney, wang_2010
from .trainer import Trainer

CHOI_SETS = {"1": "line", "2": "circle", "3": "mixed"}  # the paper's training sets
SEEDS = range(5)  # of the models of choi-2001, where one training is a lottery
CHOI: dict[str, Trainer] = {
    **{f"choi-2001-published-{k}": choi_2001.supervised(name, "published") for k, name in CHOI_SETS.items()},
    "choi-2001-expected": choi_2001.supervised("mixed", "expected"),
    "choi-2001-end-to-end": choi_2001.end_to_end("mixed", 1.0, 196.0, 600),
    "choi-2001-wide": choi_2001.end_to_end("broad", 0.01, 5000.0, 1200),
    **{f"choi-2001-modes-{k}": choi_2001.modes_supervised(name) for k, name in CHOI_SETS.items()},
    "choi-2001-modes-end-to-end": choi_2001.modes_end_to_end("mixed", choi_2001.BANK),
    "choi-2001-modes-wide": choi_2001.modes_end_to_end("broad", choi_2001.WIDE_BANK),
    "choi-2001-modes-motions": choi_2001.modes_of_motion,
}
TITI: dict[str, Trainer] = {
    f"titi-guney-{speed}{rate}-{model}": titi_guney.as_published(slowness, model, interval)
    for rate, interval in (("", 1.0), ("-20hz", 0.05))
    for speed, slowness in (("sluggish", 1e4), ("tuned", 1.0))
    for model in ("linear", "literal", "anfis", "network")
}
TITI |= {f"titi-guney-imm-{model}": titi_guney.on_the_imm(model) for model in ("literal", "anfis", "history")}
TRAINERS: dict[str, Trainer] = {
    "lee-2003-ga": lee.by_genetic_algorithm(0.95),
    "lee-2003-ga-error": lee.by_genetic_algorithm(1.0),
    **{f"lee-2003-ga-{weight:g}": lee.by_genetic_algorithm(weight) for weight in lee.SWEPT},
    "lee-2003-best": lee.with_transition("lee-2003", 3, 2),
    "lee-2003-best-constants": lee.with_transition("lee-2003", 3, 1),
    "fuzzy-kalman": lee.with_transition("random-accelerations", 1, 6),
    "fuzzy-imm-along": lee.along_track(2, (0.02, 100.0)),
    **TITI,
    "nn-kf": titi_guney.fed_by_history("network", "innovations", **NETWORK),
    "anfis-kf": titi_guney.fed_by_history("anfis", "sums", **ANFIS["sums"]),
    **CHOI,
    **wang_2010.MODELS,
    **aimm.MODELS,
    **correctors.MODELS,
    "nnvsmm": choi_2001.end_to_end("broad", 0.01, 5000.0, 1200, velocity_share=0.2),
}


def train(name: str, seed: int = 0, quick: bool = False) -> Any:
    """The filter of this name, trained again; the same seed gives the same filter.

    quick: less of everything, to see that it runs. Errors: ValueError for a name not in `TRAINERS`.
    """
    if name not in TRAINERS:
        raise ValueError(unknown("model", name, TRAINERS))
    return TRAINERS[name](seed, quick)
