"""`jink report`: a page over a whole folder of tracks, or over some of its targets, or over a file of tracks."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..frozen import frozen
from ..io.errors import InputError
from .exit_status import PACKAGES, exit_status
from .request import Quiet, TilesOption, check_tiles, output_path, progress_line, say, words_of

if TYPE_CHECKING:
    import polars as pl

_FILES = (".parquet", ".arrow", ".feather")


@frozen(kw_only=True)
class ReportRequest:
    """Write a page over tracks that are there already.

    A folder of any size becomes an overview: a map, targets over time, and the targets that are least consistent. Their
    tracks are on a second page beside it.
    """

    tracks: Annotated[
        str,
        typer.Argument(
            metavar="FOLDER|FILE",
            show_default=False,
            help="A folder that jink track wrote, or a .parquet or .arrow file of tracks.",
        ),
    ]
    output: Annotated[
        str | None, typer.Option("--output", "-o", metavar="FILE", help="The page. Default: beside the tracks.")
    ] = None
    target: Annotated[
        list[str] | None,
        typer.Option(metavar="NAMES", help="Show the tracks of these targets instead (with commas, or repeated)."),
    ] = None
    tiles: TilesOption = None
    quiet: Quiet = False


def run_report(request: ReportRequest) -> int:
    """Exit status: 0 done, 1 a failure that is not the input's fault, 2 unusable input or request, 130 interrupted."""
    return exit_status(
        lambda: _run(request),
        packages=(*PACKAGES, "pyarrow"),
        extra="archive",
        interrupted="interrupted; nothing was written",
    )


def _run(request: ReportRequest) -> int:
    from ..archive.folder import is_archive

    given = request.tracks.rstrip("/")
    page = output_path("-o", request.output or f"{given}.html", data=given)
    assert page is not None
    check_tiles(request.tiles, page=True)
    wanted = words_of(request.target)
    written = [page]
    if "://" in given or is_archive(given):
        written += _of_folder(given, wanted, page, request)
    else:
        _of_file(given, wanted, page, request.tiles)
    if not request.quiet:
        say(f"page in {' and '.join(map(str, written))}\n")
    return 0


def _of_folder(given: str, wanted: list[str], page: Path, request: ReportRequest) -> list[Path]:
    """Write the page; the one that is written beside it."""
    from ..archive.tracked import Tracks

    tracks = Tracks(given)
    if wanted:
        _write(tracks.of_targets(wanted), page, given, request.tiles)
        return []
    from ..report.overview_page import write_overview
    from ..report.survey import survey

    with progress_line(not request.quiet) as tell:
        return [write_overview(tracks, survey(tracks, tell), page, request.tiles)]


def _of_file(given: str, wanted: list[str], page: Path, tiles: str | None) -> None:
    import polars as pl

    path = Path(given)
    if path.is_dir() or path.suffix.lower() not in _FILES:
        raise InputError(
            f"{given}: expected a folder that jink track wrote, or a {' or '.join(_FILES[:2])} file of tracks"
        )
    if not path.is_file():
        raise InputError(f"there is no file {given}")
    try:
        tracks = pl.read_parquet(path) if path.suffix == ".parquet" else pl.read_ipc(path)
    except pl.exceptions.PolarsError as error:
        raise InputError(f"{given} cannot be read: {str(error).splitlines()[0]}") from None
    if wanted:
        missing = set(wanted) - set(tracks["target"].cast(pl.String).unique()) if "target" in tracks.columns else ()
        if missing:
            raise InputError(f"{given} has no track of {', '.join(sorted(missing))}")
        tracks = tracks.filter(pl.col("target").cast(pl.String).is_in(wanted))
    _write(tracks, page, given, tiles)


def _write(tracks: pl.DataFrame, page: Path, given: str, tiles: str | None) -> None:
    from ..report.tracks_page import write_report

    write_report(tracks, page, summary={}, title=f"Tracks of {given}", tiles=tiles)
