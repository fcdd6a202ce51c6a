"""The command line: it puts the commands together.

`jink --help` must be instant. So a command imports what it needs when it runs, not when this file is imported.
"""

from __future__ import annotations

import os
import signal
import sys
from typing import Annotated, Any

try:
    import typer
except ImportError:
    sys.exit('jink: the command line needs more packages: pip install "jink[track]"')

from .compare import run_compare
from .exit_status import DEBUG, guarded
from .fit import run_fit
from .learn import run_learn
from .report import run_report
from .reproduce import run_reproduce
from .request import FLAG, Command, command_of
from .simulate import run_simulate
from .track import run_track

COMMANDS = {
    "track": run_track,
    "simulate": run_simulate,
    "compare": run_compare,
    "report": run_report,
    "reproduce": run_reproduce,
    "fit": run_fit,
    "learn": run_learn,
}

app = typer.Typer(
    help="Track targets that manoeuvre: from noisy positions to velocity, acceleration, turn rate and the "
    "probability of a manoeuvre.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
for name, run in COMMANDS.items():
    app.command(name, cls=Command)(command_of(run))


def _version(wanted: bool) -> None:
    if wanted:
        from ..models.provenance import VERSION

        typer.echo(f"jink {VERSION}")
        raise typer.Exit


@app.callback()
def root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and exit.", **FLAG)
    ] = False,
    debug: Annotated[
        bool, typer.Option(DEBUG, help="Show where an error comes from; it may stand anywhere.", **FLAG)
    ] = False,
) -> None:
    """Take the options that stand before a command."""


def main() -> Any:
    """Run the command line and exit; `python -m jink` calls itself jink as well."""
    # A command that is told to stop takes its temporary files away, as it does on Ctrl-C.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    given = [word for word in sys.argv[1:] if word != DEBUG]
    if len(given) < len(sys.argv) - 1:
        os.environ["JINK_DEBUG"] = "1"
    sys.exit(guarded(lambda: app(args=given, prog_name="jink")))
