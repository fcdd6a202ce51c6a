"""What a user writes: checked strictly by the type checker (`make lint`), and run by test_typed.py."""

import pickle

import numpy as np
from numpy.typing import NDArray

import jink


def weaving(seed: int, scans: int = 60) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times (N,) in s and positions (N, 2) in m of a target that weaves, with noise."""
    rng = np.random.default_rng(seed)
    time = np.cumsum(rng.uniform(1.0, 3.0, scans))
    truth = np.column_stack([120.0 * time, 800.0 * np.sin(time / 20.0)])
    return time, truth + rng.normal(0.0, 15.0, truth.shape)


def filters() -> dict[str, jink.IMM | jink.Kalman]:
    """Two filters to compare by hand."""
    sensor = jink.Position(sd=15.0)
    straight = jink.ConstantVelocity(acceleration_psd=0.1)
    turning = jink.CoordinatedTurn(acceleration_sd=0.5, turn_rate_psd=1e-5)
    return {
        "kalman": jink.Kalman(straight, sensor),
        "imm": jink.IMM([straight, turning], sensor, jink.Sojourn(seconds=[60.0, 20.0])),
    }


def roughness(estimate: jink.Estimate) -> float:
    """Mean size of the jumps of the velocity, m/s."""
    velocity = np.column_stack([estimate["vx"], estimate["vy"]])
    return float(np.abs(np.diff(velocity[2:], axis=0)).mean())


def followed_live(filter: jink.IMM | jink.Kalman, time: NDArray[np.float64], z: NDArray[np.float64]) -> float:
    """The last velocity along x with its sd, scan by scan."""
    live = filter.start(lag=0)
    now = live.update(time[0], z[0])
    for t, position in zip(time[1:].tolist(), z[1:], strict=True):
        now = live.update(t, position)
    assert now.status == "updated" and now.components[:2] == ("px", "vx")
    ahead = live.predict(float(time[-1]) + 5.0)
    assert ahead.sd("px") > now.sd("px")
    return now["vx"]


def main() -> dict[str, float]:
    """Filter, smooth, follow live, look at other times, copy."""
    time, z = weaving(1)
    out: dict[str, float] = {}
    for name, filter in filters().items():
        estimate = filter.filter(time, z)
        smooth = filter.smooth(time, z, lag=3)
        assert roughness(smooth) < roughness(estimate)
        last = followed_live(filter, time, z)
        assert np.isclose(last, estimate["vx"][-1])
        between = estimate.at([float(time[10]) + 0.5])
        assert len(between) == 1 and between[0].sd("px").shape == (1,)
        many = filter.start(2)
        both = many.update(0.0, z[:2])
        assert both[1]["px"].shape == (1,)
        assert pickle.loads(pickle.dumps(filter)) == filter
        out[name] = last
    return out


if __name__ == "__main__":
    print(main())
