"""`jink compare`: check what was asked, race, print the table or write it as JSON; nothing is written on an error."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .io.errors import InputError


@dataclass(frozen=True)
class CompareRequest:
    """What the command line asked for, as it came."""

    scenario: str
    filters: str
    runs: int
    seed: int
    json: str | None = None
    kind: str = "aircraft"
    columns: Sequence[str] = ()
    quiet: bool = False


def run_compare(request: CompareRequest) -> int:
    """Exit status: 0 done, 1 a failure that is not the input's fault, 2 unusable request, 130 interrupted.

    Interrupted with some runs finished, these are reported and marked partial.
    """
    try:
        return _run(request)
    except ValueError as error:
        return _failed(str(error), 2)
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] not in ("polars", "narwhals", "pyproj", "rich"):
            raise
        return _failed(f'{error.name} is missing; pip install "jink[track]" brings it', 1)
    except MemoryError:
        return _failed("not enough memory", 1)
    except OSError as error:
        return _failed(f"{error.strerror or error}: {error.filename or ''}", 1)
    except KeyboardInterrupt:
        return _failed("interrupted before any run was finished", 130)


def _run(request: CompareRequest) -> int:
    from .compare import compare
    from .track_command import parse_columns

    if request.runs < 1:
        raise InputError(f"--runs is {request.runs}; expected at least 1")
    if request.seed < 0:
        raise InputError(f"--seed is {request.seed}; expected a whole number from 0")
    output = _output(request)
    names = [name.strip() for name in request.filters.split(",") if name.strip()]
    race = compare(
        request.scenario,
        names,
        request.runs,
        request.seed,
        kind=request.kind,
        columns=parse_columns(list(request.columns)) or None,
        progress=_progress(request),
    )
    if output is not None:
        _write(race.as_dict(), output)
    if not request.quiet and request.json != "-":
        from .race.table import show

        show(race)
    return 130 if race.partial else 0


def _output(request: CompareRequest) -> Path | None:
    """Where the JSON goes, checked before the work; Path("-") is standard output."""
    if request.json is None:
        return None
    path = Path(request.json)
    if request.json != "-":
        if path.is_dir() or not path.parent.is_dir():
            raise InputError(f"--json {path}: expected a file in a folder that exists")
        if path.exists() and Path(request.scenario).exists() and path.samefile(request.scenario):
            raise InputError(f"{path} is the input; the output needs another name")
        if path.name in request.filters.split(",") or str(path) in request.filters.split(","):
            raise InputError(f"{path} is one of the filters; the output needs another name")
    return path


def _write(body: dict[str, Any], path: Path) -> None:
    text = json.dumps(body, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    if str(path) == "-":
        sys.stdout.write(text)
        return
    from .io.writing import atomically

    with atomically(path) as (temporary,):
        temporary.write_text(text, encoding="utf-8")


def _progress(request: CompareRequest) -> Any:
    if request.quiet or not sys.stderr.isatty():
        return None

    def say(done: int, asked: int) -> None:
        sys.stderr.write(f"\r{done:,} of {asked:,}" + ("\r\033[K" if done >= asked else ""))
        sys.stderr.flush()

    return say


def _failed(message: str, status: int) -> int:
    sys.stderr.write(f"jink: {message}\n")
    return status
