"""`jink track -`: JSON Lines on standard input, estimates on standard output as they come."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from ..io.errors import InputError

if TYPE_CHECKING:
    from .track import Request


def run_live(request: Request) -> int:
    """Read until the input ends; rejected lines are said on standard error. Exit status as `run_command`."""
    if len(request.inputs) > 1:
        raise InputError("'-' stands alone: standard input cannot be tracked together with files")
    for given, option in (
        (request.smooth, "--smooth"),
        (request.report, "--report"),
        (request.output, "--output"),
        (request.json, "--json"),
    ):
        if given:
            raise InputError(
                f"{option} needs the whole track; 'jink track -' writes JSON Lines to standard output"
            )
    from ..tracking.live import LiveTracks
    from .track import settings_of

    reading, settings = settings_of(request)
    tracks = LiveTracks(reading, settings)
    said = 0
    try:
        for lines in _arriving(sys.stdin.fileno()):
            estimates, rejected = tracks.take(lines)
            sys.stdout.write(estimates)
            sys.stdout.flush()
            if not request.quiet:
                sys.stderr.write("".join(f"jink: {note}\n" for note in tracks.notes[said:]) + rejected)
            said = len(tracks.notes)
    except BrokenPipeError:
        os.dup2(
            os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno()
        )  # the reader has had enough; nothing more to flush
        return 0
    except KeyboardInterrupt:
        pass
    if tracks.rows == 0:
        raise InputError("standard input is empty; JSON Lines with time and position are expected")
    if tracks.rows == tracks.rejected:
        raise InputError(f"none of the {tracks.rows} lines could be used")
    if not request.quiet:
        _say(tracks)
    return 0


def _plural(count: int, noun: str) -> str:
    return f"{count:,} {noun}" if count == 1 else f"{count:,} {noun}s"


def _say(tracks: Any) -> None:
    counts = f"{_plural(tracks.rows, 'line')}, {_plural(len(tracks.followed), 'target')}"
    sys.stderr.write(f"jink: {counts}, {tracks.rejected:,} rejected\n")


def _arriving(source: int) -> Iterator[list[bytes]]:
    """Whole lines as soon as they are there: one from a slow feed, thousands from a fast one."""
    rest = b""
    while block := os.read(source, 1 << 18):
        *lines, rest = (rest + block).split(b"\n")
        if lines:
            yield lines
    if rest.strip():
        yield [rest]
