"""How a command ends: its exit status, and what it says when it failed."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence

# what the command line works with, but `import jink` does not
PACKAGES = ("polars", "narwhals", "pyproj", "rich")


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
    as_json: say it on standard output as well. Any other error is a defect and is raised.
    """
    try:
        return command()
    except ModuleNotFoundError as error:
        name = (error.name or "").partition(".")[0]
        if name not in packages:
            raise
        return failed(f'{name} is missing; pip install "jink[{extra}]" brings it', 1, as_json=as_json)
    except mistakes as error:
        return failed(str(error), 2, as_json=as_json)
    except MemoryError:
        return failed(memory, 1, as_json=as_json)
    except OSError as error:
        return failed(f"{error.strerror or error}: {error.filename or ''}", 1, as_json=as_json)
    except KeyboardInterrupt:
        if interrupted is None:
            raise
        return failed(interrupted, 130, as_json=as_json)


def failed(message: str, status: int, *, as_json: bool = False) -> int:
    """Say why on standard error, and on standard output where JSON is expected there. Returns the status."""
    if as_json:
        sys.stdout.write(json.dumps({"error": message, "status": status}, ensure_ascii=False) + "\n")
    sys.stderr.write(f"jink: {message}\n")
    return status
