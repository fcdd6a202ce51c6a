"""What the commands share: how a request becomes a command of typer, the options of several commands, and checks."""

from __future__ import annotations

import json
import os
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import MISSING, fields
from importlib import import_module
from inspect import Parameter, Signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_type_hints

import typer
from typer.core import TyperArgument, TyperCommand, TyperOption

from ..frozen import frozen
from ..io.errors import InputError
from ..io.printable import printable, printable_json
from .plain_values import PlainValues

if TYPE_CHECKING:
    from ..scenarios.observation import Seeing

# a flag has no value, so its help shows no name for one
FLAG: dict[str, Any] = {"metavar": " "}
SENSOR = "Sensor (default: the scenario's own)"
# where the names stand that an option may have; these modules are heavy, so they are imported when names are asked for
REGISTRIES = {
    "associations": "jink.association:ASSOCIATIONS",
    "filters": "jink.catalogue:FILTERS",
    "kinds": "jink.catalogue.targets:KINDS",
    "learned": "jink.learn.recipes:RECIPES",
    "objectives": "jink.fit:OBJECTIVES",
    "optimisers": "jink.learn.rule_recipes:OPTIMISERS",
    "papers": "jink.papers:PAPERS",
    "radars": "jink.scenarios:RADARS",
    "scenarios": "jink.scenarios:SCENARIOS",
}


def names_of(registry: str) -> list[str]:
    """The names in one of `REGISTRIES`; none if a package is missing that it needs."""
    module, _, name = REGISTRIES[registry].partition(":")
    try:
        return list(getattr(import_module(module), name))
    except ModuleNotFoundError:
        return []


def completed_from(*registries: str, also: Sequence[str] = ()) -> Callable[[str], list[str]]:
    """What the shell may complete an option to; typer keeps what fits. After a comma, the next name is completed."""

    def completions(incomplete: str) -> list[str]:
        before, comma, _ = incomplete.rpartition(",")
        known = [name for registry in registries for name in names_of(registry)] + list(also)
        return [before + comma + name for name in known]

    return completions


class Command(PlainValues, TyperCommand):
    """A command whose help names what a registry holds, wherever its text says `{registry}`."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Put the names in, then show the help."""
        for shown in self.params:
            if isinstance(shown, TyperArgument | TyperOption) and shown.help:
                shown.help = re.sub(r"\{(\w+)\}", lambda found: ", ".join(names_of(found[1])), shown.help)
        super().format_help(ctx, formatter)


def command_of(run: Callable[[Any], int]) -> Callable[..., None]:
    """A function that typer can make a command of: its parameters are the fields of the request that `run` takes.

    The request is a frozen dataclass whose fields are `Annotated[type, typer.Option(...)]`. Its docstring is the
    command's help. What `run` returns is the exit status.
    """
    request = next(kind for name, kind in get_type_hints(run).items() if name != "return")
    annotations = get_type_hints(request, include_extras=True)
    parameters = [
        Parameter(
            field.name,
            Parameter.KEYWORD_ONLY,
            default=Parameter.empty if field.default is MISSING else field.default,
            annotation=annotations[field.name],
        )
        for field in fields(request)
    ]

    def command(**given: Any) -> None:
        raise typer.Exit(run(request(**given)))

    command.__doc__ = request.__doc__
    command.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    command.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
    return command


Runs = Annotated[int, typer.Option(metavar="N", help="Number of Monte Carlo runs.")]
Seed = Annotated[
    int, typer.Option(metavar="S", help="Seed of the random numbers. The same seed gives the same result.")
]
CheckRuns = Annotated[
    int, typer.Option(metavar="N", help="Number of other runs of the scenario to check the filter on.")
]
RecordedKind = Annotated[
    str,
    typer.Option(
        metavar="KIND",
        help="What the targets of a recorded file are: {kinds}.",
        autocompletion=completed_from("kinds"),
    ),
]
SafeCsv = Annotated[
    bool,
    typer.Option(
        "--safe-csv",
        rich_help_panel="Output",
        help="Put ' before text in CSV that a spreadsheet would run as a formula (= + - @ first).",
        **FLAG,
    ),
]
TilesOption = Annotated[
    str | None,
    typer.Option(
        "--tiles",
        metavar="URL",
        rich_help_panel="Output",
        help="Lay the page's map over the pictures of a server. The address has z, x and y in braces; docs/page.md "
        "shows one.",
    ),
]
Columns = Annotated[
    list[str] | None,
    typer.Option(metavar="MAP", help="Name the columns of a file yourself: target=hex,time_ms=t."),
]
JsonFile = Annotated[
    str | None,
    typer.Option("--json", metavar="FILE", help="Write all figures as JSON; - writes them to standard output."),
]
Json = Annotated[bool, typer.Option("--json", help="Print all figures as JSON instead of tables.", **FLAG)]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print no tables and no progress.", **FLAG)]


@frozen(kw_only=True)
class SensorOptions:
    """The options that change how a scenario's targets are measured; None leaves it as the scenario has it."""

    sensor: Annotated[
        str | None,
        typer.Option(
            metavar="SENSOR",
            rich_help_panel=SENSOR,
            help="A radar ({radars}) or the standard deviation of a measured position in metres.",
            autocompletion=completed_from("radars"),
        ),
    ] = None
    interval: Annotated[
        float | None, typer.Option(metavar="SECONDS", rich_help_panel=SENSOR, help="Time between scans.")
    ] = None
    jitter: Annotated[
        float | None,
        typer.Option(metavar="SECONDS", rich_help_panel=SENSOR, help="Each scan is early or late by up to this much."),
    ] = None
    detection: Annotated[
        float | None,
        typer.Option(metavar="P", rich_help_panel=SENSOR, help="Probability that a scan detects the target."),
    ] = None
    outliers: Annotated[
        float | None,
        typer.Option(metavar="SHARE", rich_help_panel=SENSOR, help="Share of scans whose noise is 20 times as large."),
    ] = None
    bias: Annotated[
        str | None,
        typer.Option(metavar="B1,B2", rich_help_panel=SENSOR, help="Added to each measured component (m, rad or m/s)."),
    ] = None

    @property
    def sensor_options(self) -> dict[str, Any]:
        """Those that were given."""
        every = {field.name: getattr(self, field.name) for field in fields(SensorOptions)}
        return {name: value for name, value in every.items() if value is not None}

    @property
    def seeing(self) -> Seeing:
        """How the targets are to be measured."""
        from ..scenarios.observation import Seeing

        return Seeing(**self.sensor_options)

    def scenario_called(self, name: str, kind: str) -> Any:
        """The scenario by its name, or from a file of recorded tracks, measured as asked. Errors: ValueError."""
        from ..scenarios import by_name

        path = Path(name)
        if path.suffix and path.is_file():
            from ..scenarios.recorded import recorded

            return self.seeing.of(recorded(path, kind=kind))
        if "/" in name or path.suffix in (".parquet", ".csv", ".json", ".jsonl", ".arrow"):
            raise InputError(f"there is no file {name}")
        return self.seeing.of(by_name(name))


def check_at_least(least: int, **given: int | None) -> None:
    """Errors: InputError for an option (named by the keyword) that was given a smaller number."""
    for name, value in given.items():
        if value is not None and value < least:
            raise InputError(f"--{name.replace('_', '-')} is {value}; expected at least {least}")


def check_tiles(given: str | None, page: bool) -> None:
    """Errors: InputError for an address that is none of tiles, and where no page is asked for."""
    if given is None:
        return
    if not page:
        raise InputError("--tiles is for a page: --report page.html")
    from ..report.tiles import Tiles

    Tiles(given)


def check_seed(seed: int) -> None:
    """Errors: InputError for a negative one."""
    if seed < 0:
        raise InputError(f"--seed is {seed}; expected a whole number from 0")


def check_kind(kind: str) -> None:
    """Errors: InputError for a kind of target that is unknown."""
    from ..catalogue.targets import KINDS
    from ..checks import unknown

    if kind not in KINDS:
        raise InputError(f"--kind: {unknown('kind of target', kind, KINDS)}")


def parse_columns(given: Sequence[str] | None) -> dict[str, str]:
    """`target=hex,time_ms=t` (also repeated) to role and column name. Errors: InputError."""
    pairs: dict[str, str] = {}
    for item in ",".join(given).split(",") if given else []:
        role, equals, name = item.partition("=")
        if not equals or not role.strip() or not name.strip():
            raise InputError(f"--columns: {item!r} is not ROLE=COLUMN, for example target=hex,altitude_ft=alt")
        pairs[role.strip()] = name.strip()
    return pairs


def parse_sites(given: Sequence[str] | None) -> dict[str, tuple[float, ...]]:
    """`48.1,11.6,520` or `NAME=48.1,11.6` to latitude, longitude (degrees) and altitude (m), by name; "" for one that
    has none. Errors: InputError.
    """
    sites: dict[str, tuple[float, ...]] = {}
    for item in given or ():
        name, equals, text = item.rpartition("=")
        values: list[float] = []
        with suppress(ValueError):
            values += [float(part) for part in text.split(",")]
        if len(values) not in (2, 3) or not (abs(values[0]) <= 90.0 and abs(values[1]) <= 360.0):
            raise InputError(f"--site is {item!r}; expected LATITUDE,LONGITUDE[,ALTITUDE] (degrees, metres)")
        if name in sites or (bool(equals) != all(sites) and sites):
            raise InputError(f"--site is {item!r} beside others; expected a name of its own for each: NAME=LAT,LON")
        sites[name.strip()] = tuple(values)
    return sites


def words_of(given: Sequence[str] | None) -> list[str]:
    """The words of an option that takes several, separated by commas or given one by one."""
    return [word.strip() for item in given or () for word in item.split(",") if word.strip()]


def output_path(option: str, given: str | None, *, stdout: bool = False, data: str = "") -> Path | None:
    """Where an option's output goes, checked before the work begins; stdout: Path("-") is allowed. Errors: InputError.

    data: the input, which must not be overwritten.
    """
    if given is None:
        return None
    path = Path(given)
    if given == "-":
        if stdout:
            return path
        raise InputError(f"{option} -: expected a file")
    if path.is_dir() or not path.parent.is_dir():
        raise InputError(f"{option} {path}: expected a file in a folder that exists")
    if not os.access(path.parent, os.W_OK):
        raise InputError(f"{option} {path}: no permission to write in {path.parent}")
    if data and path.exists() and Path(data).exists() and path.samefile(data):
        raise InputError(f"{path} is the input; the output needs another name")
    return path


def filter_path(given: str | None, data: str) -> Path | None:
    """Where a new filter goes, checked before the work begins. Errors: InputError."""
    path = output_path("-o", given, data=data)
    if path is not None and path.suffix != ".json":
        raise InputError(f"-o {path}: expected a name that ends in .json")
    return path


def json_text(body: Any, **options: Any) -> str:
    """JSON as the commands write it."""
    return (
        printable_json(json.dumps(body, **{"indent": 2, "ensure_ascii": False, "allow_nan": False, **options})) + "\n"
    )


def say(text: str) -> None:
    """Write prose to standard output; names in it cannot do anything to the terminal."""
    sys.stdout.write(printable(text))


@contextmanager
def progress_line(wanted: bool) -> Iterator[Callable[[str], None] | None]:
    """A function that writes its text over one line of standard error; None if nobody wants or sees it."""
    if not wanted or not sys.stderr.isatty():
        yield None
        return

    def say(text: str) -> None:
        sys.stderr.write(f"\r\033[K{printable(text, one_line=True)}")
        sys.stderr.flush()

    try:
        yield say
    finally:
        sys.stderr.write("\r\033[K")
        sys.stderr.flush()
