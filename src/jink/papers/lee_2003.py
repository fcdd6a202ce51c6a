"""Lee, Joo & Park 2003: the GA-identified fuzzy IMM, with its rule tables."""

from __future__ import annotations

from . import lee
from .paper import Paper

LEE_2003 = Paper(
    name="lee-2003",
    source="Lee, Joo & Park, A GA-Based IMM Method for Tracking a Maneuvering Target, Trans. KIEE 52D-1-3, 2003, "
    "table 3",
    runs=2000,
    quick_runs=200,
    experiments=lambda models: [
        lee.experiment(
            lee.published((0.6089, 0.1235), (0.6003, 0.1176), (0.5138, 0.0845)), models, lee.fitted_adaptive(models)
        )
    ],
    draw=lee.draw,
    readings=lee.READINGS,
    remarks=(
        "The published figures come from 100 runs: their standard error is √(runs/100) times the one shown here.",
        "The GA of the paper's size with λ = 0.95 leaves one rule per sub-model, which is a constant; with λ = 1 it "
        "keeps several, and “pos ÷ its constants” says what they add.",
        "The published rules act like three constant noise levels; compare “constants” with “fuzzy-imm”.",
        "A single tuned Kalman filter (kalman-cv) beats both adaptive IMMs.",
        "The two-stage recursion with noise on its bias is not optimal; compare “two-stage” with “augmented”.",
        "Intervals in standard deviations of the estimator need no level in m/s², which answers the paper's objection "
        "to the AIMM. The two-stage estimator's own deviation is far too small, so c is 32. With the augmented "
        "filter's c is 8, and both errors are smaller.",
    ),
)
