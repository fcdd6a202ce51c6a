"""The corrections in the plane that come with the package: see docs/corrector.md."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import Any

from ...catalogue.choose import default_filter
from ...filters.corrected import Corrected
from ...learn.learning import learn
from ...learn.plane import FEWEST, drawn, fit_plane, left_over
from ...learn.plane_inputs import Pairs
from ...models.provenance import VERSION, Trained
from ...models.sensor import Position
from .trainer import Trainer

SETTINGS: dict[str, Any] = {"families": 4000, "hidden": 48, "epochs": 36}
RECORDED = "JINK_FLIGHTS"  # in the environment: the quickstart collection of the package traffic
QUICK: dict[str, Any] = {"families": FEWEST, "hidden": 4, "epochs": 1}


def corrector(kind: str) -> Trainer:
    """Of a kind's default filter. The sensor in the file is only an example: the correction goes with any."""

    def make(seed: int, quick: bool) -> Corrected:
        how = QUICK if quick else SETTINGS
        found = fit_plane(kind, seed=seed, **how)
        unseen = Pairs.joined(drawn(kind, how["families"] // 10, seed + 1))
        ratios = left_over(found, unseen)
        said = Trained(
            data=f"{how['families']} random families of the kind {kind}",
            method=f"network of {how['hidden']} units that remember, {how['epochs']} epochs of Adam",
            seeds=(seed,),
            figures=list(zip(("position RMSE ÷ default's", "velocity RMSE ÷ default's"), ratios, strict=True)),
            version=VERSION,
        )
        return Corrected(default_filter(kind, Position(sd=50.0)), replace(found, trained=said))

    return make


def of_recorded(kind: str) -> Trainer:
    """As `jink learn corrector FILE --kind KIND` makes it of recorded tracks; the file is named by ``RECORDED``."""

    def make(seed: int, quick: bool) -> Corrected:
        if quick:
            return corrector(kind)(seed, True)
        path = os.environ.get(RECORDED)
        if not path:
            raise ValueError(f"corrector-{kind}: name the file of recorded tracks that it learns on in {RECORDED}")
        return learn("corrector", path, kind=kind, seed=seed).filter

    return make


MODELS: dict[str, Trainer] = {
    "corrector-fighter": corrector("fighter"),
    "corrector-aircraft": of_recorded("aircraft"),
}
