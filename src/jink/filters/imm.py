"""The interacting multiple model filter."""

from collections.abc import Sequence
from typing import Literal, TypedDict

from numpy.typing import ArrayLike

from ..models.coasting import Coasting
from ..models.motion import AnyMotion
from ..models.outliers import Outliers
from ..models.sensor import AnySensor
from ..models.start import OnePoint, Prior, TwoPoint
from ..models.switching import Transition
from .bank import Bank
from .parts import Parts
from .plain import MODES


class IMMOptions(TypedDict, total=False):
    """What an IMM can be told beside its modes, its sensor and its transition."""

    transition_step: float | None
    mode_probability: ArrayLike | None
    mixing: Literal["prior", "unbiased"]
    linearisation: Literal["ekf", "ukf"]
    outliers: Outliers | None
    initial: TwoPoint | OnePoint | Prior | None
    coast: float | None
    coasting: Coasting | None


class IMM(Bank):
    """Interacting multiple models of any mix of motion models and state dimensions.

    cⱼ = Σᵢ Πᵢⱼ μᵢ;  wᵢⱼ = Πᵢⱼ μᵢ / cⱼ;  each mode starts from the mixture of the wᵢⱼ, predicts and updates;  μⱼ ∝ cⱼ
    N(z; ẑⱼ, Sⱼ)

    transition: a stay probability, a matrix with transition[i, j] = p(mode j now | mode i at the scan before), or a
    :class:`jink.Sojourn` in continuous time; with ``transition_step`` (s) the matrix holds for that elapsed time. No
    time, no switching: two sensors at the same instant do not switch twice. mode_probability: initial, by default the
    stationary one. mixing: a component a mode has and its source lacks comes from the mode's own independent prior
    ("prior"), or from the mode's own estimate ("unbiased"). coasting: a :class:`jink.Coasting`, what a target does
    while nothing is measured. The other arguments are those of :class:`jink.Kalman`.
    Source: Blom & Bar-Shalom, IEEE Trans. AC-33(8), 1988; mixed dimensions: Granström, Willett & Bar-Shalom, Fusion
    2015.
    """

    arguments = (*MODES, "coasting")

    def __init__(
        self,
        motions: Sequence[AnyMotion],
        sensor: AnySensor | Sequence[AnySensor],
        transition: Transition,
        *,
        transition_step: float | None = None,
        mode_probability: ArrayLike | None = None,
        mixing: Literal["prior", "unbiased"] = "prior",
        linearisation: Literal["ekf", "ukf"] = "ekf",
        outliers: Outliers | None = None,
        initial: TwoPoint | OnePoint | Prior | None = None,
        coast: float | None = None,
        coasting: Coasting | None = None,
    ) -> None:
        self._declare(motions, sensor, outliers, initial, coast)
        self.transition, self.transition_step = transition, transition_step
        self.mode_probability, self.mixing, self.linearisation = mode_probability, mixing, linearisation
        self.coasting = coasting
        self._prepare(
            transition=transition,
            transition_step=transition_step,
            mode_probability=mode_probability,
            mixing=mixing,
            linearisation=linearisation,
            coast=coast,
            coasting=coasting,
            parts=self._parts(),
        )

    def _parts(self) -> Parts | None:
        """What a filter of the same arguments does otherwise than the IMM."""
        return None

    def __repr__(self) -> str:
        inner = f"[{', '.join(map(repr, self.motions))}], {', '.join(map(repr, self.sensors))}"
        return f"{type(self).__name__}({inner}, {self.transition!r})"
