"""Self-contained HTML pages to look at what a filter made of the data."""

from .tracks_page import write_report

__all__ = ["write_report"]
