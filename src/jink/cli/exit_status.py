"""How a command ends: its exit status, and the one line that says why it failed.

A command runs in `exit_status`, which knows its words; all of it runs in `guarded`, past which no error comes. A
traceback is shown with `--debug` alone.
"""

from __future__ import annotations

import csv
import errno
import json
import os
import sys
import traceback
from collections.abc import Callable, Sequence
from contextlib import suppress

from ..io.printable import printable, printable_json
from . import streams

# what the command line works with, but `import jink` does not
PACKAGES = ("polars", "narwhals", "pyproj", "rich")
DEBUG = "--debug"
READER_GONE = 141  # what shells say of a program whose reader has gone: 128 and SIGPIPE


def exit_status(
    command: Callable[[], int],
    *,
    mistakes: type[ValueError] = ValueError,
    packages: Sequence[str] = PACKAGES,
    extra: str = "track",
    memory: str = "not enough memory",
    interrupted: str | None = None,
    as_json: bool = False,
) -> int:
    """Run a command: 0 done, 1 a failure that is not the input's fault, 2 unusable input or request, 130 interrupted.

    mistakes: the errors that are the input's fault. packages: those that may be missing; extra: what installs them.
    memory: what is said when memory runs out; interrupted: what is said on Ctrl-C (None: the caller handles it).
    as_json: say it on standard output as well. Any other error is a defect, which `guarded` says.
    """
    try:
        return command()
    except ModuleNotFoundError as error:
        name = (error.name or "").partition(".")[0]
        if name not in packages:
            raise
        return failed(f'{name} is missing; pip install "jink[{extra}]" brings it', 1, as_json=as_json)
    except MemoryError:
        return failed(memory, 1, as_json=as_json)
    except KeyboardInterrupt:
        if interrupted is None:
            raise
        return failed(interrupted, 130, as_json=as_json)
    except mistakes as error:
        return failed(str(error), 2, as_json=as_json)
    except BaseException as error:  # a panic of polars is no Exception
        if _reader_gone(error):  # click would end with 1
            streams.give_up()
            return READER_GONE
        known = _known(error)
        if known is None:
            raise
        return failed(*known, as_json=as_json)


def guarded(run: Callable[[], object]) -> int:
    """Run the whole command line, standard output emptied, and return the exit status. No error comes past it."""
    try:
        streams.make_whole()
        try:
            run()
            status = 0
        except SystemExit as end:
            # click and rich end with 1 where they find that nobody reads
            if isinstance(end.__context__, BrokenPipeError):
                streams.give_up()
                return READER_GONE
            status = _status(end)
        streams.flush()
        return status
    except KeyboardInterrupt:
        return failed("interrupted", 130)
    except BaseException as error:
        streams.give_up()
        if _reader_gone(error):
            return READER_GONE
        known = _known(error)
        if known is not None:
            return failed(*known)
        first = (str(error).splitlines() or [""])[0]
        return failed(f"{type(error).__name__}: {first} (a defect of jink; {DEBUG} shows where)", 1)


def _status(end: SystemExit) -> int:
    """The status that `sys.exit` was given: a number, nothing, or a message."""
    if end.code is None or isinstance(end.code, int):
        return end.code or 0
    return failed(str(end.code).removeprefix("jink: "), 1)


def _reader_gone(error: BaseException) -> bool:
    """Whether nobody reads standard output any more; that is no failure, so nothing is said."""
    written_by_polars = isinstance(error, OSError) or _of_polars(error)
    return isinstance(error, BrokenPipeError) or (written_by_polars and f"os error {errno.EPIPE})" in str(error))


def _of_polars(error: BaseException) -> bool:
    polars = sys.modules.get("polars")
    return polars is not None and isinstance(error, polars.exceptions.PolarsError | polars.exceptions.PanicException)


def _known(error: BaseException) -> tuple[str, int] | None:
    """What is said of an error that comes from outside jink, and its status; None for a defect."""
    if isinstance(error, OSError):
        what = error.strerror or str(error) or type(error).__name__
        where = error.filename if error.filename is not None else ""
        return f"{what}: {streams.shown(where)}" if where != "" else what, 1
    if isinstance(error, csv.Error):
        return f"the input cannot be read as CSV: {error}", 2
    if isinstance(error, UnicodeError):
        return f"a name or text is not UTF-8: {error}", 2
    if isinstance(error, RecursionError):
        return "the input is nested too deeply", 2
    if isinstance(error, MemoryError):
        return "not enough memory", 1
    if not _of_polars(error):
        return None
    first = (str(error).splitlines() or [type(error).__name__])[0]
    full = f"os error {errno.ENOSPC}" in str(error)
    return os.strerror(errno.ENOSPC) if full else f"polars: {first}", 1


def failed(message: str, status: int, *, as_json: bool = False) -> int:
    """Say why on standard error, and on standard output where JSON is expected there. Returns the status."""
    if as_json:
        sys.stdout.write(printable_json(json.dumps({"error": message, "status": status}, ensure_ascii=False)) + "\n")
    with suppress(OSError, ValueError):  # nobody may be there to read it
        if os.environ.get("JINK_DEBUG") and sys.exc_info()[0] is not None:
            traceback.print_exc()
        sys.stderr.write(f"jink: {printable(message)}\n")
        sys.stderr.flush()
    return status
