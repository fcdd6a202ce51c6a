"""The command line, run in this process."""

from typer.testing import CliRunner

from jink.cli.main import app


def run(*arguments: object) -> tuple[int, str, str]:
    """Exit status, standard output and standard error of `jink` with these arguments; its faults are raised."""
    result = CliRunner(env={"COLUMNS": "200"}).invoke(app, [str(a) for a in arguments])
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.exit_code, result.stdout, result.stderr
