"""The page of `jink compare sky-… --report`: plots, truth and every entrant's tracks of one run, and the tables."""

from __future__ import annotations

import os

from ..compare.sky_race import SkyRace
from .shell import write_page
from .sky_table import HEAD, MORE, row_of, second_row_of
from .tracks_page import page_text


def write_sky_page(race: SkyRace, path: str | os.PathLike[str], *, command: str = "") -> None:
    """Write one HTML file. The race needs its example. command: what does it again. Errors: ValueError, OSError."""
    write_page(path, sky_page_text(race, command))


def sky_page_text(race: SkyRace, command: str = "") -> str:
    """The page as HTML. Errors: ValueError for a race without an example."""
    if race.example is None:
        raise ValueError("race: has no example; expected that of race_on_sky(example=True)")
    sky = race.sky
    summary = {
        "sky": f"{sky.name}: {sky.summary}",
        "runs": race.runs,
        "seed": race.seed,
        "shown": "the first run; figures are of all runs",
        "GOSPA": f"cut-off {sky.cutoff:g} m, p = α = 2",
        **({"command": command} if command else {}),
        "figures": [dict(zip(HEAD, row_of(e), strict=True)) for e in race.entrants],
        "CLEAR-MOT and SIAP": [dict(zip(MORE, second_row_of(e), strict=True)) for e in race.entrants],
    }
    return page_text(race.example.tracks, summary, f"Trackers on {sky.name}", race.example.sky)
