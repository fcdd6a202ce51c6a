"""Lee, Joo & Park 2002: the short English version of lee-2003, with another rule set that is not printed."""

from __future__ import annotations

from . import lee
from .paper import Paper

LEE_2002 = Paper(
    name="lee-2002",
    source="Lee, Joo & Park, GA-Based IMM Method Using Fuzzy Logic for Tracking a Maneuvering Target, 2002, table 2",
    runs=2000,
    quick_runs=200,
    experiments=lambda models: [
        lee.experiment(lee.published((0.6089, 0.1235), (0.6003, 0.1176), (0.5107, 0.0818)), models)
    ],
    draw=lee.errors,
    readings=(
        *lee.READINGS,
        "The paper does not print the rule set behind 0.5107/0.0818; “fuzzy-imm” uses the tables of lee-2003.",
        "“Error/scan” is not defined here; lee-2003, which has the same figures for both adaptive IMMs, defines it.",
        "The conclusions speak of two scenarios; one is described, and run here.",
        "The likelihood prints S where S⁻¹ belongs.",
    ),
)
