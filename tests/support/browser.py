"""Pages in headless Chromium: what a test looks at."""

import os
import shutil
from dataclasses import dataclass, field
from typing import Any

FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]


def chromium_path() -> str | None:
    """Path of an installed Chromium or Chrome, JINK_CHROMIUM first."""
    names = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
    return os.environ.get("JINK_CHROMIUM") or next((p for p in map(shutil.which, names) if p), None)


@dataclass
class Opened:
    """A page and everything it complained about or asked for."""

    page: Any
    complaints: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def chosen(self) -> str:
        return self.page.locator("#chosen").inner_text()

    def value(self, panel: str) -> str:
        return self.page.locator(f'[data-panel="{panel}"]').inner_text()
