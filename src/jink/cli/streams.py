"""Standard input, output and error as a command finds them: closed, full, or unable to write every character."""

from __future__ import annotations

import codecs
import errno
import io
import os
import sys
from contextlib import suppress
from typing import Any

ESCAPED = "jink-escaped"
NAMES = {"stdin": "standard input", "stdout": "standard output", "stderr": "standard error"}


class Closed(io.TextIOBase):
    """A standard stream that was closed before jink began: every use of it is an error with its name."""

    def __init__(self, name: str) -> None:
        self.what = name

    def _refuse(self, *_: Any) -> Any:
        raise OSError(errno.EBADF, f"{self.what} is closed")

    write = read = readline = fileno = _refuse

    @property
    def buffer(self) -> Any:
        """The same for bytes."""
        return self

    def isatty(self) -> bool:
        """A closed stream is no terminal."""
        return False


def make_whole() -> None:
    """Let the standard streams be there and take every text: `\\u00e9` stands for what they cannot write."""
    _occupy()
    codecs.register_error(ESCAPED, _escaped)
    for name, words in NAMES.items():
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, Closed(words))
        elif name != "stdin" and isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=ESCAPED)


def _occupy() -> None:
    """Put the null device where a standard stream was closed: no file that is opened later takes its number."""
    with suppress(OSError):
        while (number := os.open(os.devnull, os.O_RDWR)) <= 2:
            os.set_inheritable(number, True)
        os.close(number)


def _escaped(error: UnicodeError) -> tuple[str, int]:
    """Characters as `\\u` and four hexadecimal digits, which JSON reads too."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    units = error.object[error.start : error.end].encode("utf-16-be", "surrogatepass").hex()
    return "".join(f"\\u{units[k : k + 4]}" for k in range(0, len(units), 4)), error.end


def shown(path: object) -> str:
    """A file's name as text, whatever its bytes."""
    if isinstance(path, str | bytes):
        return os.fsencode(path).decode("utf-8", "backslashreplace")
    return str(path)


def flush() -> None:
    """Send what was written on its way; errors come here and not at the interpreter's end."""
    for stream in (sys.stdout, sys.stderr):
        if not isinstance(stream, Closed):
            stream.flush()


def give_up() -> None:
    """Write no more to standard output: what waits for it goes nowhere."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.stdout.flush()
