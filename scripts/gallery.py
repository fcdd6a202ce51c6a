"""Draw docs/images/scenarios/*.svg and write docs/gallery.md: one picture per scenario, and per sky of several targets.

Lines are the truth of the first three runs, dots what the sensor saw of the first. Skies of more than 200 aircraft look
like those of 200 and are named under them. With --check nothing is written; the status is 1 if a file is out of date.
"""

from __future__ import annotations

import math
import re
import sys
from html import escape
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from jink.scenarios import SCENARIOS
from jink.scenarios.scenario import Scenario
from jink.scenarios.skies import SKIES, Sky

DOCS = Path(__file__).parents[1] / "docs"
FOLDER = DOCS / "images" / "scenarios"
WIDTH, HEIGHT, EDGE = 320, 200, 14
MOST = 200  # aircraft of a sky that is drawn
STYLE = (
    ".r{fill:none;stroke-width:1.6;stroke-linejoin:round}.a{stroke:#c8501e}.b{stroke:#2a6fb0}.c{stroke:#5f8f3e}"
    ".d{fill:#888}text{font:11px sans-serif;fill:#555}.s{stroke:#555}"
    "@media(prefers-color-scheme:dark){text{fill:#bbb}.s{stroke:#bbb}.a{stroke:#f08a50}.b{stroke:#6fb1ee}.c{stroke:#9ccb78}}"
)
PATH = re.compile(r'd="[^"]*"')
Points = NDArray[np.float64]


def fewer(points: Points, error: float = 0.35) -> Points:
    """The line through fewer points (Douglas and Peucker), nowhere further than ``error`` pixels from it."""
    keep, todo = {0, len(points) - 1}, [(0, len(points) - 1)]
    while todo:
        first, last = todo.pop()
        if last - first < 2:
            continue
        along = points[last] - points[first]
        off = points[first + 1 : last] - points[first]
        length = np.hypot(*along)
        far = np.hypot(*off.T) if length < 1e-9 else np.abs(off[:, 0] * along[1] - off[:, 1] * along[0]) / length
        worst = int(np.argmax(far))
        if far[worst] > error:
            middle = first + 1 + worst
            keep.add(middle)
            todo += [(first, middle), (middle, last)]
    return points[sorted(keep)]


def numbers(points: Points) -> str:
    """Coordinates of a path, to a tenth of a pixel."""
    return "L".join(f"{x:.1f} {y:.1f}" for x, y in points)


def picture(lines: list[Points], dots: Points, title: str, note: str = "") -> str:
    """An SVG of lines and dots (N, 2): a plan with a bar of length, or with a note a chart that fills the picture."""
    everything = np.vstack([*lines, dots])
    low, high = everything.min(axis=0), everything.max(axis=0)
    room = np.array([WIDTH - 2 * EDGE, HEIGHT - 2 * EDGE - 16.0])
    scale = room / np.maximum(high - low, 1e-9)
    if not note:
        scale = np.full(2, scale.min())
    begin = np.array([EDGE, EDGE]) + (room - scale * (high - low)) / 2

    def placed(points: Points) -> Points:
        x, y = ((points - low) * scale).T
        return np.column_stack([begin[0] + x, begin[1] + scale[1] * (high - low)[1] - y])

    paths = [
        f'<path class="r {"abc"[k % 3]}" d="M{numbers(fewer(placed(line)))}"/>'
        for k, line in reversed(list(enumerate(lines)))
    ]
    seen = "".join(f"M{x - 0.8:.1f} {y - 0.8:.1f}h1.6v1.6h-1.6z" for x, y in placed(dots))
    notes = f'<text x="{EDGE}" y="{HEIGHT - 6}">{note}</text>' if note else bar(scale[0])
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img">'
        f"<title>{escape(title)}</title>"
        f'<style>{STYLE}</style><path class="d" d="{seen}"/>{"".join(paths)}{notes}</svg>\n'
    )


def bar(scale: float) -> str:
    """A bar of a round length, of at most a third of the picture."""
    most = WIDTH / 3 / scale
    step = 10.0 ** math.floor(math.log10(most))
    length = max(step * m for m in (1, 2, 5) if step * m <= most)
    name = f"{length / 1e3:g} km" if length >= 1e3 else f"{length:g} m"
    end = EDGE + length * scale
    return f'<path class="s" d="M{EDGE} {HEIGHT - 9}H{end:.1f}"/><text x="{end + 5:.1f}" y="{HEIGHT - 5}">{name}</text>'


def of_scenario(scenario: Scenario) -> str:
    """Plan view of the first three runs; of one axis, its velocity against time."""
    simulated = scenario.simulate(4, seed=0)
    runs = range(4) if "training" in scenario.summary else range(3)
    truth = simulated.truth
    title = f"{scenario.name}: {scenario.summary}"
    if truth.position.shape[2] == 1:
        line = np.column_stack([simulated.time[0], truth.velocity[0, :, 0]])
        (start, slow), (end, fast) = line.min(axis=0), line.max(axis=0)
        note = f"time {start:.0f} to {end:.0f} s →   velocity {slow:.0f} to {fast:.0f} m/s ↑"
        return picture([line], line[:0], title, note)
    lines = [truth.position[r, :, :2] for r in runs]
    if all(np.allclose(line, lines[0]) for line in lines):
        lines = lines[:1]
    z = seen_places(scenario, simulated.z[0])
    return picture(lines, z[np.isfinite(z).all(axis=1)], title)


def seen_places(scenario: Scenario, z: Points) -> Points:
    """Measurements as positions in the plane: those of a radar from range and azimuth."""
    sensor = scenario.observation.sensor
    if not hasattr(sensor, "range_sd"):
        return z[:, :2]
    height = z[:, 2] if z.shape[1] > 2 else 0.0
    ground = np.sqrt(np.maximum(z[:, 0] ** 2 - np.square(height), 0.0))
    return np.asarray(sensor.site[:2]) + ground[:, None] * np.column_stack([np.sin(z[:, 1]), np.cos(z[:, 1])])


def of_sky(sky: Sky) -> str:
    """Truth of one run, and all plots of its middle scan."""
    run = sky.run(0)
    paths: dict[int, list[Points]] = {}
    for there in run.truth:
        for number, point in zip(there.ids.tolist(), there.points, strict=True):
            paths.setdefault(number, []).append(point)
    lines = [np.array(path) for path in paths.values() if len(path) > 1]
    return picture(lines, run.scans[len(run.scans) // 2].z, f"{sky.name}: {sky.summary}")


def page(drawn: dict[str, str], others: list[str]) -> str:
    """docs/gallery.md."""
    rows = [
        "# The scenarios in pictures",
        "",
        "Lines are the truth of the first three runs with `--seed 0`, or one line where every run takes the same path.",
        "Dots are what the sensor saw of the first run. Scenarios of one axis are drawn as velocity against time.",
        "`scripts/gallery.py` draws them; [scenarios and radars](scenarios.md) says what is in each.",
        "",
        "    jink simulate random-turns --runs 3 -o turns.parquet",
        "",
        "## One target",
        "",
    ]
    for name, summary in drawn.items():
        if name in SKIES and rows.count("## Several targets, plots without names") == 0:
            rows += ["## Several targets, plots without names", ""]
            rows += ["Dots are all plots of the middle scan: false ones, and those of the targets.", ""]
        rows += [f"**`{name}`**: {summary}", "", f"![{name}](images/scenarios/{name}.svg)", ""]
    rows += [
        "More aircraft in the same square, or slower scans: " + ", ".join(f"`{name}`" for name in others) + ".",
        "",
    ]
    return "\n".join(rows)


def files() -> dict[Path, str]:
    """Every file that the gallery has, and its text."""
    small = {name: sky for name, sky in SKIES.items() if sky.targets <= MOST and not name.startswith("sky-regional-")}
    drawn = {name: of_scenario(scenario) for name, scenario in SCENARIOS.items()}
    drawn |= {name: of_sky(sky) for name, sky in small.items()}
    summaries = {name: thing.summary for name, thing in {**SCENARIOS, **small}.items()}
    out = {FOLDER / f"{name}.svg": svg for name, svg in drawn.items()}
    return out | {DOCS / "gallery.md": page(summaries, [name for name in SKIES if name not in small])}


def differ(one: str, other: str) -> bool:
    """Other words, or lines that end elsewhere; the last digits of a line may differ from machine to machine."""
    reach = [[float(n) for n in re.findall(r"-?\d+\.\d", "".join(PATH.findall(text)))] for text in (one, other)]
    bounds = [(min(each, default=0.0), max(each, default=0.0)) for each in reach]
    return PATH.sub("", one) != PATH.sub("", other) or not np.allclose(*bounds, atol=1.0)


def main() -> int:
    """Write all, or say what is not up to date."""
    wanted = files()
    if "--check" in sys.argv:
        known = {*FOLDER.glob("*.svg"), DOCS / "gallery.md"}
        stale = [
            path.name for path, text in wanted.items() if path not in known or differ(path.read_text("utf-8"), text)
        ]
        stale += [path.name for path in known - set(wanted)]
        if stale:
            print("not up to date:", ", ".join(stale))
        return int(bool(stale))
    FOLDER.mkdir(parents=True, exist_ok=True)
    for path, text in wanted.items():
        path.write_text(text, encoding="utf-8")
    sizes = [len(text) for text in wanted.values()]
    print(f"{len(wanted) - 1} pictures, {sum(sizes) / 1e3:.0f} kB, the largest {max(sizes) / 1e3:.1f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
