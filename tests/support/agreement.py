"""How closely the engine agrees with the textbook."""

from __future__ import annotations

from oracle import twin as tw

TOLERANCE = 1e-9


def assert_agrees(twin, data, smooth=False):
    """To 1e-9 times conditioning over 1e5; smoothed, plus ten times the effect of rounding its input."""
    oracle, native = tw.run_oracle(twin, data, smooth), tw.run_native(twin, data, smooth)
    scale = max(1.0, tw.conditioning(oracle) / 1e5)
    rounding = tw.rounding_effect(twin, data) if smooth else {}
    got = tw.distances(native, oracle)
    far = {k: f"{v:.1e}" for k, v in got.items() if not v <= TOLERANCE * scale + 10 * rounding.get(k, 0.0)}
    assert not far, f"conditioning scale {scale:.1f}: {far}"
