"""Other multiple-model filters than the IMM: pseudo-Bayesian of first and second order, and without interaction."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from numpy.typing import ArrayLike

from .._engine import native
from ..checks import items
from ..models.motion import AnyMotion
from ..models.outliers import Outliers
from ..models.sensor import Sensor
from ..models.start import OnePoint, Prior, TwoPoint
from .imm import IMM
from .parts import Parts, adapts
from .plain import LINEARISED


class GPB1(IMM):
    """Generalised pseudo-Bayesian filter of first order: every mode starts its scan from the combined estimate.

    x⁰ⱼ = Σᵢ μᵢ xᵢ for all j;  μⱼ ∝ cⱼ N(z; ẑⱼ, Sⱼ), cⱼ = Σᵢ Πᵢⱼ μᵢ. M filters, no mixing per mode.
    Source: Ackerson & Fu, IEEE Trans. AC-15(1), 1970; Bar-Shalom, Li & Kirubarajan 2001, §11.6.3.
    """

    def _parts(self) -> Parts:
        return Parts(interaction=native.Interaction.gpb1)


class GPB2(IMM):
    """Generalised pseudo-Bayesian filter of second order: every pair of modes before and now is filtered apart, then
    merged.

    xᵢⱼ, Pᵢⱼ: mode j's filter from mode i's estimate;  wᵢⱼ ∝ Πᵢⱼ μᵢ N(z; ẑᵢⱼ, Sᵢⱼ);  μⱼ = Σᵢ wᵢⱼ, xⱼ = Σᵢ wᵢⱼ xᵢⱼ / μⱼ.
    M² filters. Source: Chang & Athans, IEEE Trans. AES-14(3), 1978; Bar-Shalom, Li & Kirubarajan 2001, §11.6.4.
    Errors: ValueError for modes that adapt to residuals: a pair has no memory of its own.
    """

    def _parts(self) -> Parts:
        if any(getattr(m, "remembers", False) for m in self.motions):
            raise ValueError(
                "motions: GPB2 keeps no memory for a pair of modes, but modes that adapt to residuals need it; "
                "use jink.IMM"
            )
        if any(adapts(m) for m in self.motions):
            self.not_smoothed = "it does not keep the noise that its modes adapt; smooth a jink.IMM of them"
        return Parts(interaction=native.Interaction.gpb2)


class StaticMM(IMM):
    """Static multiple models (multiple-model adaptive estimation): each mode filters by itself, and never switches.

    μⱼ(k) ∝ μⱼ(k−1) N(z; ẑⱼ, Sⱼ). When a target changes its mode, the right mode first has to recover from a small
    probability, which is kept above 1e-100. Source: Magill, IEEE Trans. AC-10(4), 1965; Bar-Shalom, Li & Kirubarajan
    2001, §11.6.2.
    """

    arguments = ("mode_probability", *LINEARISED)

    def __init__(
        self,
        motions: Sequence[AnyMotion],
        sensor: Sensor | Sequence[Sensor],
        *,
        mode_probability: ArrayLike | None = None,
        linearisation: Literal["ekf", "ukf"] = "ekf",
        outliers: Outliers | None = None,
        initial: TwoPoint | OnePoint | Prior | None = None,
        coast: float | None = None,
    ) -> None:
        motions = items("motions", motions, "motion models")
        n = len(motions)
        same = [[1.0 if i == j else 0.0 for j in range(n)] for i in range(n)]
        if mode_probability is None:
            mode_probability = [1.0 / max(n, 1)] * n
        super().__init__(
            motions,
            sensor,
            same,
            mode_probability=mode_probability,
            linearisation=linearisation,
            outliers=outliers,
            initial=initial,
            coast=coast,
        )

    def _parts(self) -> Parts:
        return Parts(interaction=native.Interaction.none)
