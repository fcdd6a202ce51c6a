"""What a user writes with tracks, races and live targets: checked strictly by `make lint`, run by test_typed.py."""

from pathlib import Path

import numpy as np
import polars as pl
from numpy.typing import NDArray

import jink
from jink.compare import Race, compare


class AlphaBeta:
    """A filter of two gains per axis."""

    def begin(self, z: NDArray[np.float64], R: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
        x, P = np.zeros((len(z), 4)), np.tile(np.diag([0.0, 1e4, 0.0, 1e4]), (len(z), 1, 1))
        x[:, ::2], P[:, ::2, ::2] = z, R
        return {"x": x, "P": P}

    def step(
        self,
        state: dict[str, NDArray[np.float64]],
        dt: NDArray[np.float64],
        z: NDArray[np.float64],
        R: NDArray[np.float64],
    ) -> dict[str, NDArray[np.float64]]:
        x = state["x"].copy()
        x[:, ::2] += dt[:, None] * x[:, 1::2]
        residual = np.nan_to_num(z - x[:, ::2])
        x[:, ::2] += 0.5 * residual
        x[:, 1::2] += 0.15 * residual / np.maximum(dt, 1e-9)[:, None]
        return {"x": x, "P": state["P"]}


def positions() -> pl.DataFrame:
    """Two targets in a plane."""
    rng, t = np.random.default_rng(0), np.arange(60) * 2.0
    frames: list[pl.DataFrame] = []
    for name, speed in (("a", 90.0), ("b", 140.0)):
        x, y = speed * t + rng.normal(0.0, 15.0, 60), 30.0 * t + rng.normal(0.0, 15.0, 60)
        frames.append(pl.DataFrame({"target": [name] * 60, "time": t, "x": x, "y": y}))
    return pl.concat(frames)


def raced(purpose: "jink.Purpose") -> jink.Kalman:
    return jink.Kalman(jink.ConstantVelocity(acceleration_psd=100.0), purpose.sensor)


def main(folder: Path) -> list[Path]:
    """Tracks as a table and as a page, a race of one's own filter, targets followed live."""
    tracks = jink.track(positions(), kind="aircraft", filter="imm-cv-ct")
    detailed = jink.track(positions(), details=True, smooth=True)
    assert detailed.tracks.height == tracks.height and detailed.rejected.height == 0
    pages = [jink.plot(tracks, title="Two targets").save(folder / "tracks.html"), folder / "detailed.html"]
    detailed.report(pages[1])
    race: Race = compare("choi-2001-2", {"mine": AlphaBeta(), "raced": raced, "imm": None}, runs=4)
    race.report(folder / "race.html")
    best: pl.DataFrame = race.to_frame().filter(pl.col("metric") == "position_rmse").sort("value")
    assert {"mine", "raced"} <= set(best["filter"].to_list())
    tracker = jink.LiveTracker("vessel", sensor_sd=10.0)
    for t in range(10):
        now = tracker.update("ship", float(t), x=7.0 * t, y=0.0)
        assert now is not None and now["target"] == "ship"
    again = jink.LiveTracker.load(tracker.save())
    assert len(again.predict(20.0)) == 1 and again.targets == ["ship"]
    return [*pages, folder / "race.html"]
