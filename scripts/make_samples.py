"""Make the sample files in examples/ again: radar plots, ship reports, a GPS log, and a live log. All are synthetic.

Each has targets whose motion is known here, and noise as such sources have it; nothing in them is of real people.
"""

from __future__ import annotations

import json
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).parents[1] / "examples"
START = datetime(2026, 5, 1, 8, tzinfo=UTC)
DEGREE = 111_195.0  # m of latitude


def path(time: np.ndarray, speed: float, course: float, turns: list[tuple[float, float, float]]) -> np.ndarray:
    """East and north (N, 2) in m of a target at constant speed; turns: begin, end (s) and rate (rad/s), clockwise."""
    fine = np.arange(0.0, time[-1] + 0.1, 0.1)
    rate = sum((np.where((fine >= a) & (fine < b), w, 0.0) for a, b, w in turns), np.zeros(len(fine)))
    angle = course + np.cumsum(rate) * 0.1
    step = speed * 0.1 * np.column_stack([np.sin(angle), np.cos(angle)])
    place = np.vstack([[0.0, 0.0], np.cumsum(step, axis=0)])[:-1]
    return np.column_stack([np.interp(time, fine, place[:, k]) for k in (0, 1)])


def radar(rng: np.random.Generator) -> str:
    """Plots of four aircraft by a radar at the origin: range in m, azimuth in degrees, every 4 s, one in ten missed."""
    lines = ["target,time_s,range_m,azimuth_deg"]
    aircraft = [
        ((-30e3, 20e3), 180.0, 1.6, [(120.0, 170.0, 0.035)]),
        ((25e3, 35e3), 210.0, 3.6, [(80.0, 130.0, -0.03), (260.0, 300.0, 0.05)]),
        ((10e3, -40e3), 150.0, 5.9, []),
        ((-15e3, -20e3), 240.0, 0.4, [(200.0, 230.0, 0.08)]),
    ]
    rows = []
    for n, (begin, speed, course, turns) in enumerate(aircraft):
        time = np.arange(0.0, 400.0, 4.0) + 0.7 * n
        place = np.asarray(begin) + path(time, speed, course, turns)
        distance = np.hypot(*place.T) + rng.normal(0, 50.0, len(time))
        azimuth = np.degrees(np.arctan2(place[:, 0], place[:, 1])) + rng.normal(0, 0.1, len(time))
        seen = rng.random(len(time)) < 0.9
        rows += [
            (t, f"T{n + 1}", r, a % 360.0) for t, r, a in zip(time[seen], distance[seen], azimuth[seen], strict=True)
        ]
    lines += [f"{name},{t:.2f},{r:.1f},{a:.4f}" for t, name, r, a in sorted(rows)]
    return "\n".join(lines) + "\n"


def ships(rng: np.random.Generator) -> str:
    """AIS reports of five ships: position, speed over ground in knots, course over ground in degrees."""
    lines = ["mmsi,shipname,timestamp,lat,lon,sog,cog"]
    rows = []
    for n, name in enumerate(("ALBATROSS", "CORMORANT", "DUNLIN", "EIDER", "FULMAR")):
        time = np.cumsum(rng.uniform(8.0, 14.0, 160))
        turn = [(400.0 + 100.0 * n, 600.0 + 100.0 * n, 0.006 * (-1) ** n)]
        speed = 4.0 + 1.5 * n
        place = path(time, speed, 1.1 * n, turn)
        velocity = np.gradient(place, time, axis=0)
        lat = 54.0 + (place[:, 1] + rng.normal(0, 4.0, len(time))) / DEGREE
        lon = 7.9 + 0.05 * n + (place[:, 0] + rng.normal(0, 4.0, len(time))) / (DEGREE * np.cos(np.radians(54.0)))
        knots = np.hypot(*velocity.T) / 0.514444 + rng.normal(0, 0.1, len(time))
        course = np.degrees(np.arctan2(velocity[:, 0], velocity[:, 1])) % 360.0
        for k, t in enumerate(time):
            stamp = (START + timedelta(seconds=round(float(t)))).isoformat()
            rows.append(
                (stamp, f"{211000001 + n},{name},{stamp},{lat[k]:.6f},{lon[k]:.6f},{knots[k]:.1f},{course[k]:.1f}")
            )
    return "\n".join([*lines, *(text for _, text in sorted(rows))]) + "\n"


def ride(rng: np.random.Generator) -> str:
    """A bicycle ride of 15 minutes, one position a second, with noise that drifts as that of a phone does."""
    time = np.arange(0.0, 900.0, 1.0)
    turns = [(60.0, 68.0, 0.2), (200.0, 210.0, -0.15), (330.0, 338.0, 0.2), (500.0, 516.0, 0.1), (700.0, 708.0, -0.2)]
    place = path(time, 6.0, 0.3, turns)
    drift = np.zeros((len(time), 2))
    for k in range(1, len(time)):
        drift[k] = 0.95 * drift[k - 1] + rng.normal(0, 0.6, 2)
    place = place + drift + rng.normal(0, 1.0, place.shape)
    points = []
    for k, t in enumerate(time):
        lat, lon = 52.0 + place[k, 1] / DEGREE, 5.1 + place[k, 0] / (DEGREE * np.cos(np.radians(52.0)))
        stamp = (START + timedelta(seconds=float(t))).strftime("%Y-%m-%dT%H:%M:%SZ")
        points.append(f'<trkpt lat="{lat:.7f}" lon="{lon:.7f}"><time>{stamp}</time></trkpt>')
    head = '<?xml version="1.0" encoding="UTF-8"?>\n<gpx version="1.1" creator="jink" xmlns="http://www.topografix.com/GPX/1/1">'
    return f"{head}\n<trk><name>ride</name><trkseg>\n" + "\n".join(points) + "\n</trkseg></trk></gpx>\n"


def live(rng: np.random.Generator) -> str:
    """Reports of three aircraft as JSON Lines in the order in which they came, as a receiver writes them."""
    rows = []
    for n, (speed, course, turns) in enumerate(
        [(210.0, 1.2, [(60.0, 100.0, 0.03)]), (180.0, 4.0, []), (230.0, 2.5, [(90.0, 120.0, -0.06)])]
    ):
        time = np.cumsum(rng.uniform(0.5, 2.0, 160))
        place = path(time, speed, course, turns) + rng.normal(0, 20.0, (len(time), 2))
        for k, t in enumerate(time):
            lat, lon = 50.0 + 0.1 * n + place[k, 1] / DEGREE, 8.5 + place[k, 0] / (DEGREE * np.cos(np.radians(50.0)))
            stamp = (START + timedelta(seconds=round(float(t), 1))).isoformat(timespec="milliseconds")
            height = 20_000 + 2_000 * n
            rows.append(
                (
                    t,
                    {
                        "hex": f"3c660{n}",
                        "time": stamp,
                        "lat": round(lat, 6),
                        "lon": round(lon, 6),
                        "alt_baro_ft": height,
                    },
                )
            )
    return "".join(json.dumps(row) + "\n" for _, row in sorted(rows, key=lambda each: each[0]))


SAMPLES = {"radar.csv": radar, "ships.csv": ships, "ride.gpx": ride, "live.jsonl": live}


def main() -> None:
    """Write all of them."""
    for seed, (name, make) in enumerate(SAMPLES.items()):
        (FOLDER / name).write_text(make(np.random.default_rng(seed)), encoding="utf-8")


if __name__ == "__main__":
    main()
