"""The command line: it puts the commands together.

`jink --help` must be instant. So a command imports what it needs when it runs, and only the command that is called is
imported at all.
"""

from __future__ import annotations

import gc
import os
import signal
import sys
from collections.abc import Callable
from importlib import import_module
from typing import Annotated, Any

try:
    import typer
    from typer.core import TyperGroup
except ImportError:
    sys.exit('jink: the command line needs more packages: pip install "jink[track]"')

from .exit_status import DEBUG, guarded
from .plain_values import PlainValues
from .request import FLAG, Command, command_of

# each is a file of this folder with a function run_NAME
COMMANDS = ("track", "simulate", "compare", "report", "reproduce", "fit", "learn")
GARBAGE = 100_000  # new objects after which Python looks for garbage


class Commands(PlainValues, TyperGroup):
    """All commands."""


def _version(wanted: bool) -> None:
    if wanted:
        from ..models.provenance import VERSION

        typer.echo(f"jink {VERSION}")
        raise typer.Exit


def root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and exit.", **FLAG)
    ] = False,
    debug: Annotated[
        bool, typer.Option(DEBUG, help="Show where an error comes from; it may stand anywhere.", **FLAG)
    ] = False,
) -> None:
    """Take the options that stand before a command."""


def run_of(name: str) -> Callable[[Any], int]:
    """What a command runs: a function of its request."""
    return getattr(import_module(f".{name}", __package__), f"run_{name}")


def app_of(*names: str) -> typer.Typer:
    """The command line with some commands, or with all."""
    app = typer.Typer(
        cls=Commands,
        help="Track targets that manoeuvre: from noisy positions to velocity, acceleration, turn rate and the "
        "probability of a manoeuvre.",
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    for name in names or COMMANDS:
        app.command(name, cls=Command)(command_of(run_of(name)))
    app.callback()(root)
    return app


def __getattr__(name: str) -> Any:
    """`app` is the command line with all commands, made when it is asked for."""
    if name == "app":
        return app_of()
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def main() -> Any:
    """Run the command line and exit; `python -m jink` calls itself jink as well."""
    # A command that is told to stop takes its temporary files away, as it does on Ctrl-C.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    given = [word for word in sys.argv[1:] if word != DEBUG]
    if len(given) < len(sys.argv) - 1:
        os.environ["JINK_DEBUG"] = "1"
    # A large page has to be found in one piece and cleared whole. Where memory is in pieces, that takes longer than the
    # small pages for which it stands.
    os.environ.setdefault("NUMPY_MADVISE_HUGEPAGE", "0")
    # Arrow's own allocators take and give back memory of the system for each table; in the C library's it stays.
    os.environ.setdefault("ARROW_DEFAULT_MEMORY_POOL", "system")
    called = [word for word in given[:1] if word in COMMANDS]
    # What is imported never becomes garbage, so it is looked through less often, and at the end not at all.
    gc.set_threshold(GARBAGE)
    status = guarded(lambda: app_of(*called)(args=given, prog_name="jink"))
    gc.freeze()
    sys.exit(status)
