"""Neural variable-structure multiple models: a network chooses the process noise, or weighs the modes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .._engine import native
from ..checks import with_attributes
from ..frozen import frozen
from ..models.motion import AnyMotion, NativeMode, NativeMotion, manoeuvres, name_of
from ..models.network import Network
from ..models.noise_network import ModeNetwork, NoiseNetwork
from ..models.outliers import Outliers
from ..models.sensor import Sensor
from ..models.start import OnePoint, Prior, TwoPoint
from .bank import Bank
from .parts import LARGEST_LAYER, Parts
from .plain import COMMON


def layers(network: Network) -> tuple[list[int], list[float]]:
    """Sizes from the inputs to the outputs, and each layer's weights row by row, then its biases."""
    sizes = [network.inputs, *(len(b) for b in network.biases)]
    numbers: list[float] = []
    for w, b in zip(network.weights, network.biases, strict=True):
        numbers += [float(v) for row in w for v in row] + [float(v) for v in b]
    return sizes, numbers


@frozen
class NetworkNoise:
    """A motion model whose noise variance a network chooses anew in each scan: NNVSMM, "parameter-based".

    All axes share one variance.
    q(k) = network(q(k−1), how likely the measurement is along each axis with q(k−1)); then P⁻ = F P Fᵀ + q G Gᵀ. A miss
    keeps q. Source: Choi, Samal & Ahn 2001, §3.
    """

    motion: NativeMotion
    network: NoiseNetwork
    remembers = True

    @property
    def name(self) -> str:
        """The name of this mode in an estimate."""
        return f"network_{name_of(self.motion)}"

    @property
    def manoeuvring(self) -> bool:
        """Does a target in the motion model manoeuvre?"""
        return manoeuvres(self.motion)

    def native(self, axes: int) -> NativeMode:
        """What the engine runs, with the network's first variance.

        Errors: ValueError where the network has another number of axes.
        """
        if self.network.network.inputs != 1 + axes:
            raise ValueError(
                f"NetworkNoise.network: has {self.network.network.inputs} inputs; expected {1 + axes} with {axes} axes"
            )
        mode = self.motion.native(axes)
        mode.parameters = [self.network.start] * axes + mode.parameters[axes:]
        return mode

    def check_units(self, sensor_sd: float) -> None:
        """Errors: ValueError where the network was trained on another sensor's residuals (sd in m)."""
        self.network.check_units(sensor_sd)

    def adaptation(self, axes: int) -> native.Adaptation:
        """How the engine sets its variance."""
        n = self.network
        if (n.inputs == "log-nis") != (n.output == "log-variance"):
            raise ValueError(
                f"NetworkNoise.network: inputs {n.inputs!r} go with output "
                f"{'log-variance' if n.inputs == 'log-nis' else 'variance'!r}, got {n.output!r}"
            )
        sizes, numbers = layers(n.network)
        scaling = [v for pair in zip(n.centre, n.scale, strict=True) for v in pair]
        return native.Adaptation(
            kind=native.Adapt.network,
            sizes=sizes,
            logarithmic=n.inputs == "log-nis",
            numbers=[*scaling, n.output_centre, n.output_scale, n.least, n.most, *numbers],
        )


class NeuralModes(Bank):
    """NNVSMM, "mode-based": a network scores all modes, and the best of them share the estimate.

    All modes go on from that estimate.
    w = softmax over the ``best`` highest of network(last w, log NIS of each mode);  x = Σ wⱼ xⱼ. mode_probability holds
    w. motions of any kind (constant velocity, acceleration, turns). Source: Choi, Samal & Ahn 2001, eq. 8.
    """

    arguments = ("network", *COMMON)

    not_smoothed = "its weights are scores, not probabilities; smooth its modes in a jink.IMM"

    def __init__(
        self,
        motions: Sequence[AnyMotion],
        sensor: Sensor | Sequence[Sensor],
        network: ModeNetwork,
        *,
        outliers: Outliers | None = None,
        initial: TwoPoint | OnePoint | Prior | None = None,
        coast: float | None = None,
    ) -> None:
        self._declare(motions, sensor, outliers, initial, coast)
        with_attributes("network", network, ("network", "centre", "scale", "best"), "a learned ModeNetwork")
        self.network = network
        modes = len(self.motions)
        if network.network.outputs != modes:
            raise ValueError(f"network: scores {network.network.outputs} modes, got {modes} motions")
        sizes, numbers = layers(network.network)
        if max(sizes) > LARGEST_LAYER:
            raise ValueError(f"network: expected layers of at most {LARGEST_LAYER}, got {max(sizes)}")
        scaling = [v for pair in zip(network.centre, network.scale, strict=True) for v in pair]
        scores = native.Adaptation(
            kind=native.Adapt.network,
            sizes=sizes,
            logarithmic=True,
            numbers=[*scaling, float(network.best), *numbers],
        )
        self._prepare(
            transition=np.eye(modes) if modes > 1 else 1.0,
            mode_probability=np.full(modes, 1 / modes),
            coast=coast,
            parts=Parts(interaction=native.Interaction.gpb1, scores=scores),
        )

    @property
    def non_manoeuvring(self) -> tuple[bool, ...]:
        """None of the modes: a score is no probability, so it tells no manoeuvre."""
        return (False,) * len(self.motions)

    def __repr__(self) -> str:
        return f"NeuralModes([{', '.join(map(repr, self.motions))}], {', '.join(map(repr, self.sensors))})"
