"""A page as an object: shown in a notebook, or saved to a file."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from ..compare.result import Race
from ..tracking.batch import Tracked
from .shell import escape, write_page

HEIGHT = 720  # pixels of a page in a notebook


class Page:
    """One HTML page that needs no network: ``page.html``, ``page.save(path)``, or shown in a notebook."""

    def __init__(self, html: str) -> None:
        self.html = html

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the page, whole or not at all; returns the path. Errors: OSError where it cannot be written."""
        write_page(path, self.html)
        return Path(path)

    def _repr_html_(self) -> str:
        """The page in a frame of its own, so that its style and scripts are apart from the notebook's."""
        frame = f'width="100%" height="{HEIGHT}" style="border:0" sandbox="allow-scripts"'
        return f'<iframe srcdoc="{escape(self.html)}" {frame}></iframe>'

    def __repr__(self) -> str:
        return f"Page({len(self.html) / 1e6:.2f} MB of HTML; save(path) writes it)"


def plot(what: object, *, title: str | None = None, summary: Mapping[str, object] | None = None) -> Page:
    """The page of tracks, or of a race.

    what: a DataFrame that :func:`jink.track` returned (polars, pandas, PyArrow), what it returned with
    ``details=True``, or a race of :func:`jink.compare.compare`. summary: counts and settings to be shown beside a
    DataFrame's tracks. Errors: ValueError naming the columns that are missing; TypeError for something else.
    """
    if summary is not None and not isinstance(summary, Mapping):
        raise TypeError(f"summary: expected a mapping, got {type(summary).__name__}")
    if isinstance(what, Race):
        from .race_page import page_text as race_text

        return Page(race_text(what, "", title or f"Filters on {os.path.basename(what.scenario)}"))
    from ..io.errors import InputError
    from ..io.frames import from_any
    from .tracks_page import page_text

    sky = getattr(what, "sky", None)
    if isinstance(what, Tracked):
        what, summary = what.tracks, what.summary if summary is None else summary
    try:
        tracks = from_any(what)
    except InputError:
        raise TypeError(
            "plot: what: expected tracks (a DataFrame of jink.track) or a race of jink.compare, "
            f"got {type(what).__name__}"
        ) from None
    return Page(page_text(tracks, summary or {}, title, sky))
