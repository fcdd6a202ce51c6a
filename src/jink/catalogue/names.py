"""Names for type checkers and editors; a test holds them to the registries."""

from typing import Literal

KindName = Literal["aircraft", "fighter", "vessel", "vehicle", "drone", "person"]
FilterName = Literal[
    "kalman-cv",
    "kalman-ca",
    "cv",
    "ca",
    "singer",
    "imm",
    "imm-cv-ca",
    "imm-cv-ct",
    "imm-facs",
    "imm-corrected",
    "csaf",
    "facs",
    "two-stage",
    "augmented",
    "aimm3",
    "aimm5",
    "gpb1",
    "gpb2",
    "mm",
    "vsmm-ds",
    "vsmm-ad",
    "vsmm-ag",
    "input-estimation",
    "variable-dimension",
    "fuzzy-imm",
    "fuzzy-imm-along",
    "fuzzy-kalman",
    "anfis-kf",
    "nn-kf",
    "nnvsmm",
    "nnvsmm-modes",
]
