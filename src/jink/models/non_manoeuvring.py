"""Which modes of a filter are those of a target that does not manoeuvre: the one definition, which `Estimate`
applies.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt
from typing import Any

NEAR = 4.0  # times the least noise's sd: what is still as good as straight


def non_manoeuvring_modes(motions: Sequence[Any], axes: int) -> tuple[bool, ...]:
    """For each mode, whether its target flies straight; all False where the modes do not tell manoeuvres apart.

    Straight is a motion model that is not ``manoeuvring`` (constant velocity, a known acceleration or turn rate of
    zero). Among several with noise the noise says it: no more than 4 times the least of them (as sd), and nearer to the
    least than to the most. A single mode, and modes all of which manoeuvre, tell nothing.
    """
    still = [i for i, m in enumerate(motions) if not getattr(m, "manoeuvring", True)]
    if len(motions) < 2 or not still:
        return (False,) * len(motions)
    noise = {i: _noise_sd(motions[i], axes) for i in still}
    least, most = min(noise.values()), max(noise.values())
    limit = min(NEAR * least, sqrt(least * most)) if len(still) > 1 else most
    return tuple(i in noise and noise[i] <= max(limit, least) for i in range(len(motions)))


def straight_noise(motions: Sequence[Any], straight: Sequence[bool], axes: int) -> tuple[float, float]:
    """Noise density (m²/s³) of the straight modes, horizontal and vertical, the largest of them; 0 without any.

    A noise that is constant over a step counts as one of steps of a second.
    """
    found = [(0.0, 0.0)]
    for motion, is_straight in zip(motions, straight, strict=False):
        if is_straight and hasattr(motion, "native"):
            own = motion.native(axes).parameters
            found.append((own[0], own[2] if axes > 2 and len(own) > 2 else 0.0))
    return max(level for level, _ in found), max(up for _, up in found)


def _noise_sd(motion: Any, axes: int) -> float:
    """Of the acceleration along the first axis; a density counts as that of steps of one second, a model of your own as
    none.
    """
    return sqrt(motion.native(axes).parameters[0]) if hasattr(motion, "native") else 0.0
