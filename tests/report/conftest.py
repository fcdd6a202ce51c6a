"""Made-up tracks in the schema of `jink.track`: straight legs and turns, noise as the sds say."""

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest
from browser import FLAGS, Opened, chromium_path

_RADIUS = 6_371_008.8


def make_tracks(
    targets: int = 6,
    rows: int = 300,
    *,
    seed: int = 1,
    step: float = 5.0,
    geographic: bool = True,
    altitude: bool = True,
    clock: bool = True,
    sd: float = 25.0,
    spread: float = 120e3,
    centre: tuple[float, float] = (46.5, 7.5),
) -> pl.DataFrame:
    """targets x rows of made-up estimates: 120-240 m/s, turns of up to 3 deg/s, measured every `step` s."""
    if rows < 10:
        options = {"geographic": geographic, "altitude": altitude, "clock": clock, "centre": centre}
        longer = make_tracks(targets, 10, seed=seed, step=step, sd=sd, spread=spread, **options)
        return longer.filter(pl.int_range(pl.len()) % 10 < rows)
    rng = np.random.default_rng(seed)
    shape = (targets, rows)
    time = np.cumsum(step * rng.uniform(0.5, 1.5, shape), axis=1)
    turn = np.zeros(shape)
    for t in range(targets):
        for _ in range(max(1, rows // 90)):
            begin = int(rng.integers(0, rows))
            turn[t, begin : begin + int(rng.integers(8, 25))] = np.radians(rng.uniform(0.7, 3.0)) * rng.choice([-1, 1])
    smooth = np.apply_along_axis(lambda v: np.convolve(v, np.ones(5) / 5, mode="same"), 1, turn)
    dt = np.diff(time, axis=1, prepend=time[:, :1] - step)
    speed = rng.uniform(120, 240, (targets, 1)) + 20 * np.sin(time / 400 + rng.uniform(0, 6, (targets, 1)))
    heading = rng.uniform(0, 2 * np.pi, (targets, 1)) + np.cumsum(smooth * dt, axis=1)
    climb = 8 * np.clip(np.sin(time / 500 + rng.uniform(0, 6, (targets, 1))), 0, 0.7)
    vx, vy = speed * np.cos(heading), speed * np.sin(heading)
    x = rng.uniform(-spread, spread, (targets, 1)) + np.cumsum(vx * dt, axis=1)
    y = rng.uniform(-spread, spread, (targets, 1)) + np.cumsum(vy * dt, axis=1)
    z = 3000 + np.cumsum(climb * dt, axis=1)
    tangential = np.gradient(speed, axis=1) / dt
    settle = 1 + 12 * np.exp(-np.arange(rows) / 3.0)
    busy = np.clip(np.abs(smooth) / np.radians(0.8), 0, 1) * 0.97 + 0.02 + 0.01 * rng.random(shape)
    flat: dict[str, np.ndarray] = {
        "x": x,
        "y": y,
        "z": z,
        "velocity_x": vx,
        "velocity_y": vy,
        "velocity_z": climb,
        "acceleration_x": tangential * np.cos(heading) - speed * smooth * np.sin(heading),
        "acceleration_y": tangential * np.sin(heading) + speed * smooth * np.cos(heading),
        "acceleration_z": np.gradient(climb, axis=1) / dt,
        "speed": speed,
        "course": np.mod(np.pi / 2 - heading, 2 * np.pi),
        "climb_rate": climb,
        "turn_rate": smooth,
    }
    sds = {
        "x": 12.0,
        "y": 12.0,
        "z": 6.0,
        "velocity_x": 1.6,
        "velocity_y": 1.6,
        "velocity_z": 0.7,
        "acceleration_x": 0.25,
        "acceleration_y": 0.25,
        "acceleration_z": 0.2,
        "speed": 1.6,
        "course": 0.012,
        "climb_rate": 0.7,
        "turn_rate": 0.002,
    }
    noise = rng.normal(size=(len(flat), *shape))
    for k, name in enumerate(list(flat)):
        s = sds[name] * settle * (1 + busy)
        flat[name] = flat[name] + 0.25 * s * noise[k]
        flat[f"{name}_sd"] = s
    flat["course"] = np.mod(flat["course"], 2 * np.pi)
    innovation = rng.normal(size=(3, *shape)) * 1.03
    gated = rng.random(shape) < 0.004
    predicted = rng.random(shape) < 0.01
    status = np.where(gated, "gated", np.where(predicted, "predicted", "updated"))
    status[:, :2] = "initialised"
    dof = 3 if altitude else 2
    nis = (innovation[:dof] ** 2).sum(axis=0) + 400.0 * gated
    flat |= {
        "manoeuvring": busy,
        "probability_constant_velocity": 1 - busy,
        "probability_constant_acceleration": 0.25 * busy,
        "probability_coordinated_turn": 0.75 * busy,
        "segment": np.cumsum(np.diff(busy > 0.5, axis=1, prepend=0) != 0, axis=1),
        "measured_x": np.where(predicted, np.nan, x + sd * rng.normal(size=shape) + 900 * gated),
        "measured_y": np.where(predicted, np.nan, y + sd * rng.normal(size=shape)),
        "nis": np.where(np.isin(status, ["updated", "gated"]), nis, np.nan),
        "nis_dof": np.full(shape, float(dof)),
    }
    if geographic:
        lat0, lon0 = centre
        flat["latitude"] = lat0 + np.degrees(flat["y"] / _RADIUS)
        flat["longitude"] = lon0 + np.degrees(flat["x"] / (_RADIUS * np.cos(np.radians(lat0))))
        flat["longitude"] = np.mod(flat["longitude"] + 180, 360) - 180
        if altitude:
            flat["altitude"] = flat["z"]
    if not altitude:
        for name in [n for n in flat if n.startswith(("z", "velocity_z", "acceleration_z", "climb_rate"))]:
            del flat[name]
    frame = pl.DataFrame({name: np.asarray(v).ravel() for name, v in flat.items()})
    seconds = time.ravel() + np.repeat(rng.uniform(0, 4000, targets), rows)
    moments = pl.Series((1_533_099_600 + seconds) * 1e6).cast(pl.Int64).cast(pl.Datetime("us", "UTC"))
    return frame.with_columns(
        target=pl.Series([f"{0x4B1600 + 37 * i:06x}" for i in range(targets)]).gather(
            np.repeat(np.arange(targets), rows)
        ),
        part=pl.Series((np.arange(rows) > 0.8 * rows).astype(int).repeat(targets).reshape(rows, targets).T.ravel()),
        time=moments if clock else pl.Series(seconds),
        status=pl.Series(status.ravel()),
    )


SUMMARY = {
    "input": {"files": 1, "rows": 301_234, "targets": 200, "time zone": "UTC"},
    "cleaning": {"duplicate times": 12, "stale positions": 4_310, "unsorted rows": 0, "rejected rows": 1_020},
    "measurement noise": {"horizontal sd (m)": 24.7, "vertical sd (m)": 7.6, "estimated from": "data"},
    "filter": "IMM: constant velocity, constant acceleration, coordinated turn",
    "smoothed": True,
}


@pytest.fixture
def tracks() -> Callable[..., pl.DataFrame]:
    """The generator of made-up tracks."""
    return make_tracks


@pytest.fixture
def summary() -> dict[str, object]:
    """A summary as the CLI gives it."""
    return dict(SUMMARY)


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """Headless Chromium. A machine without a browser or playwright skips what needs it, saying so."""
    if os.environ.get("JINK_SANITIZED"):
        pytest.skip("a browser does not start under a sanitizer: the page is not opened in one")
    sync_api = pytest.importorskip(
        "playwright.sync_api", reason="playwright is not installed: the page is not opened in a browser"
    )
    path = chromium_path()
    if path is None:
        pytest.skip("no Chromium or Chrome found (set JINK_CHROMIUM to its path): the page is not opened in a browser")
    with sync_api.sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=path, args=FLAGS)
        yield started
        started.close()


@pytest.fixture
def open_page(browser) -> Iterator[Callable[..., Opened]]:
    """open_page(path): open it and wait until it is drawn."""
    contexts = []

    def open_it(path: Path, *, size=(1280, 800), anchor="", dark=False) -> Opened:
        width, height = size
        context = browser.new_context(
            viewport={"width": width, "height": height},
            color_scheme="dark" if dark else "light",
            reduced_motion="reduce",
        )
        contexts.append(context)
        opened = Opened(context.new_page())
        opened.page.on("console", lambda m: opened.complaints.append(f"{m.type}: {m.text}"))
        opened.page.on("pageerror", lambda e: opened.complaints.append(f"error: {e}"))
        opened.page.on("request", lambda r: opened.requests.append(r.url))
        opened.page.goto(path.as_uri() + anchor)
        opened.page.wait_for_selector("html[data-ready]", state="attached", timeout=10_000)
        opened.page.wait_for_timeout(100)
        return opened

    yield open_it
    for context in contexts:
        context.close()
