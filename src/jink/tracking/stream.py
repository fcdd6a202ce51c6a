"""Lines in, estimates out: JSON Lines from a file descriptor are answered on standard output as they come."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator

from ..io.errors import InputError
from .live import LiveTracks


def answer(source: int, tracks: LiveTracks, *, quiet: bool = False) -> None:
    """Read from a file descriptor until it ends; notes and rejected lines go to standard error unless quiet.

    A reader that has gone away and Ctrl-C end it too. Errors: InputError when no line could be used.
    """
    said = 0
    try:
        for lines in arriving(source):
            estimates, rejected = tracks.take(lines)
            sys.stdout.write(estimates)
            sys.stdout.flush()
            if not quiet:
                sys.stderr.write("".join(f"jink: {note}\n" for note in tracks.notes[said:]) + rejected)
            said = len(tracks.notes)
        left = tracks.finish()
        if not quiet:
            sys.stderr.write(left)
    except BrokenPipeError:
        # the reader has had enough; the interpreter must not try to flush at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return
    except KeyboardInterrupt:
        pass
    if tracks.rows == 0:
        raise InputError("standard input is empty; expected JSON Lines with time and position")
    if tracks.rows == tracks.rejected:
        raise InputError(f"none of the {tracks.rows} lines could be used")
    if not quiet:
        counts = f"{_plural(tracks.rows, 'line')}, {_plural(len(tracks.followed), 'target')}"
        sys.stderr.write(f"jink: {counts}, {tracks.rejected:,} rejected\n")


def arriving(source: int) -> Iterator[list[bytes]]:
    """Whole lines as soon as they are there: one from a slow feed, thousands from a fast one."""
    rest = b""
    while block := os.read(source, 1 << 18):
        *lines, rest = (rest + block).split(b"\n")
        if lines:
            yield lines
    if rest.strip():
        yield [rest]


def _plural(count: int, noun: str) -> str:
    return f"{count:,} {noun}" if count == 1 else f"{count:,} {noun}s"
