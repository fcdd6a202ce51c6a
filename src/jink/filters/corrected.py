"""An IMM with a learned correction of what it gives out, in the plane."""

from __future__ import annotations

from .._engine import native
from ..checks import with_attributes
from ..models.plane_corrector import PlaneCorrector, even_inputs
from .bank import Bank
from .imm import IMM
from .parts import LARGEST_LAYER
from .plain import plain


class Corrected(Bank):
    """x̂ + c: the filtered estimates of ``filter`` with the learned correction of ``corrector`` added in the plane.

    P goes out as W P W, with one factor for position and velocity. The filter goes on from its own estimate, so
    that the correction cannot make it diverge; likelihood, NIS and mode probabilities stay its own. The correction
    fades to nothing where its inputs leave the range of the training, and where the innovations speak against it.
    After a miss or a rejected measurement the last correction goes on, c_p + Δt c_v in position, and P is the
    filter's own. A start is not corrected, nor is anything that is smoothed: smoothing gives what the filter itself
    gives. Errors: TypeError for another filter than an IMM, ValueError for one that is not of the corrector's
    modes. Method: docs/corrector.md.
    """

    arguments = ("corrector",)

    def __init__(self, filter: IMM, corrector: PlaneCorrector) -> None:
        with_attributes("filter", filter, ("declaration", "sensors", "motions"), "a filter such as jink.IMM")
        if not isinstance(corrector, PlaneCorrector):
            raise TypeError(f"corrector: expected a PlaneCorrector, got {type(corrector).__name__}")
        if not isinstance(filter, IMM) or filter.declaration is None:
            raise TypeError("filter: expected a jink.IMM of jink's own motion and sensor models")
        if len(filter.motions) != corrector.modes:
            raise ValueError(f"filter: expected {corrector.modes} modes, as in the training, got {len(filter.motions)}")
        if not {"px", "ax", "py", "ay"} <= set(filter.components):
            raise ValueError("filter: expected two axes at least, and a mode that accelerates")
        if corrector.hidden > LARGEST_LAYER:
            raise ValueError(f"corrector: expected at most {LARGEST_LAYER} units in a layer, got {corrector.hidden}")
        self.filter_, self.corrector = filter, corrector
        self.motions, self.sensors = filter.motions, filter.sensors
        self.outliers, self.initial, self.coast = filter.outliers, filter.initial, filter.coast
        self.not_smoothed = filter.not_smoothed
        self.declaration = native.Declaration(filter.declaration)
        self.declaration.aid = native.Aid(
            kind=native.AidInputs.plane,
            model=native.AidModel.network,
            inputs=even_inputs(corrector.modes),
            outputs=1,
            sizes=corrector.sizes,
            numbers=corrector.numbers(),
        )
        self.engine = native.Engine(self.declaration)

    def described(self) -> dict[str, object]:
        """The filter under the correction, and the correction."""
        return {"filter": "Corrected", "of": self.filter_.described(), "corrector": plain(self.corrector)}

    def __repr__(self) -> str:
        return f"Corrected({self.filter_!r}, {self.corrector.hidden} units)"
