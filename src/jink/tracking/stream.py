"""Lines in, estimates out: JSON Lines from a file descriptor are answered on standard output as they come."""

from __future__ import annotations

import os
import queue
import sys
import threading
from collections.abc import Iterator

from ..io.errors import InputError
from ..io.printable import printable
from .live import LiveTracks
from .live_lines import LONGEST, TooLong

HELD = 256  # messages that wait for whoever reads standard error


class Messages:
    """Standard error by a thread of its own: a reader that does not read it stops nothing; what is lost is counted."""

    def __init__(self, quiet: bool) -> None:
        self.quiet, self.lost = quiet, 0
        self.waiting: queue.Queue[bytes | None] = queue.Queue(HELD)
        self.thread: threading.Thread | None = None
        try:
            self.handle = sys.stderr.fileno()
        except (OSError, ValueError, AttributeError):
            self.handle = -1  # standard error is no file, and takes everything

    def say(self, text: str) -> None:
        """One or several lines."""
        if self.quiet or not text:
            return
        text = printable(text)
        if self.handle < 0:
            sys.stderr.write(text)
            return
        if self.thread is None:
            self.thread = threading.Thread(target=self._write, daemon=True)
            self.thread.start()
        try:
            self.waiting.put_nowait(text.encode("utf-8", "backslashreplace"))
        except queue.Full:
            self.lost += text.count("\n")

    def close(self, last: str = "") -> None:
        """Write what waits, if somebody reads it within a second."""
        lost = f"jink: {self.lost:,} messages were not read in time\n" if self.lost else ""
        self.say(lost + last)
        if self.thread is not None:
            try:
                self.waiting.put(None, timeout=1.0)
            except queue.Full:
                return
            self.thread.join(1.0)

    def _write(self) -> None:
        while (text := self.waiting.get()) is not None:
            try:
                while text:
                    text = text[os.write(self.handle, text) :]
            except OSError:
                return


def answer(source: int, tracks: LiveTracks, *, quiet: bool = False) -> None:
    """Read from a file descriptor until it ends; notes and rejected lines go to standard error unless quiet.

    A reader that has gone away and Ctrl-C end it too. Errors: InputError when no line could be used.
    """
    said = 0
    messages = Messages(quiet)
    try:
        for lines in arriving(source):
            estimates, rejected = tracks.take(lines)
            if estimates:
                sys.stdout.write(estimates)
                sys.stdout.flush()
            messages.say("".join(f"jink: {note}\n" for note in tracks.notes[said:]) + rejected)
            said = len(tracks.notes)
        messages.say(tracks.finish())
    except BrokenPipeError:
        # the reader has had enough; the interpreter must not try to flush at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        messages.close()
        return
    except KeyboardInterrupt:
        pass
    except BaseException:
        messages.close()
        raise
    if tracks.rows == 0 or tracks.rows == tracks.rejected:
        messages.close()
        if tracks.rows == 0:
            raise InputError("standard input is empty; expected JSON Lines with time and position")
        hint = "" if tracks.lines.columns else "; expected JSON Lines, and of other formats a file instead of -"
        raise InputError(f"none of {_plural(tracks.rows, 'line')} could be used{hint}")
    counts = f"{_plural(tracks.rows, 'line')}, {_plural(len(tracks.followed), 'target')}"
    messages.close(f"jink: {counts}, {tracks.rejected:,} rejected\n")


def arriving(source: int) -> Iterator[list[bytes]]:
    """Whole lines as soon as they are there: one from a slow feed, thousands from a fast one."""
    rest: list[bytes] = []  # the beginning of a line whose end has not come
    held = 0
    while block := os.read(source, 1 << 18):
        first, *others = block.split(b"\n")
        if held <= LONGEST:
            rest.append(first)
        held += len(first)
        if not others:
            continue
        *lines, last = [_line(rest, held), *others]
        yield lines
        rest, held = [last], len(last)
    if held and (line := _line(rest, held)).strip():
        yield [line]


def _line(pieces: list[bytes], length: int) -> bytes:
    return b"".join(pieces) if length <= LONGEST else TooLong(b"".join(pieces)[:LONGEST])


def _plural(count: int, noun: str) -> str:
    return f"{count:,} {noun}" if count == 1 else f"{count:,} {noun}s"
