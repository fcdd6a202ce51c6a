"""Draw docs/images/report.webp anew: the page of the README's command, as headless Chromium shows it."""

from __future__ import annotations

import base64
import sys
import tempfile
from pathlib import Path

import jink

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests" / "support"))

PICTURE = ROOT / "docs" / "images" / "report.webp"
TARGET = "4bc842"
SIZE = {"width": 1280, "height": 800}


def main() -> None:
    """Track the example flights, open their page, keep what is seen."""
    from browser import FLAGS, chromium_path
    from playwright.sync_api import sync_playwright

    tracked = jink.track(ROOT / "examples" / "flights.parquet", smooth=True, details=True)
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        page_file = jink.plot(tracked, title="Tracks of flights.parquet").save(Path(folder) / "tracks.html")
        browser = playwright.chromium.launch(executable_path=chromium_path(), args=FLAGS)
        page = browser.new_page(viewport=SIZE, reduced_motion="reduce")
        page.goto(f"{page_file.as_uri()}#target={TARGET}")
        page.wait_for_selector("html[data-ready]", state="attached")
        page.wait_for_timeout(500)
        session = page.context.new_cdp_session(page)
        shot = session.send("Page.captureScreenshot", {"format": "webp", "quality": 82})
        browser.close()
    PICTURE.write_bytes(base64.b64decode(shot["data"]))
    print(f"{PICTURE.relative_to(ROOT)}: {PICTURE.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
