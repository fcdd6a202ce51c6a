"""Draw the images of docs/fit.md: three cards of the page that `jink fit --report` writes for the example flights.

python scripts/fit_docs.py        # needs playwright and a Chromium
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright

ROOT = Path(__file__).parents[1]
CARDS = {
    "fit-gain": "Held-out tracks: log-likelihood",
    "fit-track": "gained most",
    "fit-consistency": "Consistency after",
}


def main() -> None:
    """Fit, open the page, keep the cards."""
    browser = os.environ.get("JINK_CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "fitted.html"
        command = [Path(sys.executable).with_name("jink"), "fit", "examples/flights.parquet", "--starts", "1"]
        subprocess.run([*command, "--report", report, "--quiet"], cwd=ROOT, check=True)
        with sync_playwright() as play:
            opened = play.chromium.launch(executable_path=browser, args=["--no-sandbox"])
            page = opened.new_page(viewport={"width": 1320, "height": 900}, device_scale_factor=1.5)
            page.goto(report.as_uri())
            for name, title in CARDS.items():
                card = page.locator("section.card", has_text=title)
                card.screenshot(path=ROOT / "docs" / "images" / f"{name}.png")
            opened.close()


if __name__ == "__main__":
    main()
