"""Sizes of pages, and how long a browser takes to show them.

    python -m benchmarks.pages [TRACKS.parquet ...]              (without: the example flights, smoothed)
    python -m benchmarks.pages TRACKS.parquet --maplibre DIST    (and MapLibre GL with the same tracks)

DIST is the folder dist/ of the npm package maplibre-gl (measured: 6.17.0). Its page has the lines alone, in one colour.
A page is open when the second frame after its drawing has been shown.
"""

from __future__ import annotations

import argparse
import base64
import json
import os
import shutil
import statistics
import tempfile
import time
from pathlib import Path
from typing import Any

FLIGHTS = Path(__file__).parents[1] / "examples" / "flights.parquet"
ROUNDS = 5
READY = "html[data-ready=yes]"
FRAMES = "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
MAPLIBRE = """<!doctype html><meta charset="utf-8"><body style="margin:0">
<div id="map" style="width:900px;height:700px"></div>
<script type="application/json" id="lines">LINES</script>
<script type="module">
const from64 = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
const url = (text) => URL.createObjectURL(new Blob([from64(text)], { type: "text/javascript" }));
const { Map, setWorkerUrl } = await import(url("LIBRARY"));
setWorkerUrl(url("WORKER"));
const lines = JSON.parse(document.getElementById("lines").textContent);
const layers = [{ id: "t", type: "line", source: "t", paint: { "line-color": "#c00", "line-width": 1.5 } }];
const style = { version: 8, sources: { t: { type: "geojson", data: lines } }, layers };
new Map({ container: "map", style, center: CENTRE, zoom: 4 }).once("idle", () => {
  document.documentElement.dataset.ready = "yes";
});
</script>"""


def jink_page(tracks: Any, path: Path) -> float:
    """Write the page; seconds of CPU that it took."""
    from jink.report import write_report

    begin = time.process_time()
    write_report(tracks, path, summary={})
    return time.process_time() - begin


def maplibre_page(tracks: Any, dist: Path, path: Path) -> None:
    """The same tracks as lines of MapLibre GL, in one file."""
    features = []
    for (_name,), track in tracks.group_by("target", maintain_order=True):
        places = track.select("longitude", "latitude").drop_nulls().to_numpy().round(5)
        shape = {"type": "LineString", "coordinates": places.tolist()}
        features.append({"type": "Feature", "properties": {}, "geometry": shape})
    packed = {
        "LIBRARY": base64.b64encode((dist / "maplibre-gl.mjs").read_bytes()).decode(),
        "WORKER": base64.b64encode((dist / "maplibre-gl-worker.mjs").read_bytes()).decode(),
        "CENTRE": json.dumps([tracks["longitude"].mean(), tracks["latitude"].mean()]),
        "LINES": json.dumps({"type": "FeatureCollection", "features": features}, separators=(",", ":")),
    }
    text = MAPLIBRE
    for name, value in packed.items():
        text = text.replace(name, value, 1)
    path.write_text(text, encoding="utf-8")


def opening(browser: Any, path: Path) -> float:
    """Seconds from the address to the drawn page."""
    page = browser.new_page(viewport={"width": 1280, "height": 900})
    begin = time.perf_counter()
    page.goto(path.as_uri())
    page.wait_for_selector(READY, timeout=60_000)
    page.evaluate(FRAMES)
    took = time.perf_counter() - begin
    page.close()
    return took


def measure(tables: list[Path], dist: Path | None) -> list[tuple[str, int, float, float]]:
    """(what, bytes, seconds of CPU to write, median seconds to open) of each page."""
    import polars as pl
    from playwright.sync_api import sync_playwright

    found = []
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        chromium = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
        browser = playwright.chromium.launch(executable_path=chromium)
        pages: list[tuple[str, Path, float]] = []
        for table in tables:
            tracks = pl.read_parquet(table)
            name = f"{table.stem}: {tracks['target'].n_unique()} targets, {tracks.height} rows"
            path = Path(folder) / f"{len(pages)}.html"
            pages.append((f"jink, {name}", path, jink_page(tracks, path)))
            if dist:
                path = Path(folder) / f"{len(pages)}.html"
                maplibre_page(tracks, dist, path)
                pages.append((f"MapLibre GL, {name}", path, float("nan")))
        times: dict[str, list[float]] = {name: [] for name, _, _ in pages}
        for _ in range(ROUNDS):
            for name, path, _ in pages:
                times[name].append(opening(browser, path))
        browser.close()
        found = [(name, path.stat().st_size, wrote, statistics.median(times[name])) for name, path, wrote in pages]
    return found


def example() -> Path:
    """Tracks of the example flights, smoothed, in a temporary file."""
    import polars as pl

    import jink

    path = Path(tempfile.mkdtemp()) / "flights.parquet"
    tracks = jink.track(str(FLIGHTS), smooth=True, details=True).tracks
    assert isinstance(tracks, pl.DataFrame)
    tracks.write_parquet(path)
    return path


def main() -> None:
    """Print a line per page."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("tracks", nargs="*", type=Path)
    options.add_argument("--maplibre", type=Path)
    given = options.parse_args()
    for name, size, wrote, opened in measure(given.tracks or [example()], given.maplibre):
        writing = f", written in {wrote:.2f} s of CPU" if wrote == wrote else ""
        print(f"{name}: {size / 1e6:.2f} MB{writing}, open after {opened:.2f} s")


if __name__ == "__main__":
    main()
