"""The default IMM with its learned correction in the plane, which aircraft get where nothing is smoothed."""

from __future__ import annotations

import json
from pathlib import Path

from ..filters.corrected import Corrected
from ..models.plane_corrector import PlaneCorrector
from ..models.provenance import Trained
from .interacting import imm
from .purpose import Named, Purpose, Unfit

# kinds that have a correction in the plane, and what it was trained on
TRAINED = {"fighter": "random families", "aircraft": "random families and real flights"}
CORRECTED = tuple(TRAINED)


def imm_corrected(purpose: Purpose) -> Named:
    """The default IMM of the kind with a correction in the plane, trained on targets of the kind."""
    if purpose.axes < 2:
        raise Unfit("its correction is in the plane; the sensor measures one axis")
    if purpose.kind not in CORRECTED:
        raise Unfit(f"its correction was trained for {' and '.join(CORRECTED)}; the kind of target is {purpose.kind}")
    base = imm(purpose)
    return Named(
        filter=Corrected(base.filter, correction(purpose.kind)),
        words=f"{base.words}, corrected in the plane by a network trained on {TRAINED[purpose.kind]}",
        fitted=base.fitted,
        note=base.note,
    )


def correction(kind: str) -> PlaneCorrector:
    """The one that comes with the package; it alone is read, for every run of aircraft does so."""
    file = Path(__file__).parent / "models" / f"corrector-{kind}.json"
    given = json.loads(file.read_text(encoding="utf-8"))["corrector"]
    trained = given.pop("trained")
    for each in (given, trained):
        del each["kind"]
    return PlaneCorrector(**given, trained=Trained(**trained))
