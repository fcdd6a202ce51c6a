"""A fair race of filters: the same random numbers for all, standard errors, no verdict without an interval."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..archive.folder import check_named, is_archive
from ..catalogue.registry import FILTERS
from ..io.errors import InputError
from ..scenarios import SCENARIOS, Scenario, by_name
from ..tracking.lag import Lag
from .entrants import ALWAYS, ENTRANTS, check_names, with_default
from .own_filters import Entry, own_filters
from .result import Race

__all__ = ["ALWAYS", "ENTRANTS", "FILTERS", "Race", "compare"]


def compare(
    scenario: str | os.PathLike[str] | Scenario,
    filters: str | Sequence[str] | Mapping[str, Entry] = (),
    runs: int = 1000,
    seed: int = 0,
    *,
    kind: str = "aircraft",
    columns: Mapping[str, str] | None = None,
    progress: Callable[[int, int], None] | None = None,
    lag: int | str | None = None,
) -> Race:
    """Race filters on a scenario, on a file that `jink simulate` wrote, or without truth on one of recorded positions.

    scenario a name, a :class:`jink.scenarios.Scenario` or a file; filters names of ``ENTRANTS``, "all", files
    that ``save`` wrote, "file.py:name", or a mapping of your own filters by name: a filter, a function of the
    :class:`jink.catalogue.purpose.Purpose`, a motion model, an object with ``begin`` and ``step``, or None for jink's
    filter of that name; raw measurements, tuned Kalman filters, the default IMM and the clairvoyant bound take
    part always. runs and seed of the Monte Carlo experiment; kind of the targets in a file and
    columns of it, role to name, as for :func:`jink.track`; progress(done,
    runs). lag: every filter takes part a second time, with what is measured so many scans (2) or seconds ("8s") later.
    Interrupted (Ctrl-C), the finished runs are returned, ``partial`` being true.
    Errors: InputError (a ValueError) for unknown names, unusable files, runs below 1 or a seed that is none.
    """
    if isinstance(runs, bool) or not isinstance(runs, int) or runs < 1:
        raise InputError(f"runs is {runs!r}; expected a whole number of at least 1")
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        raise InputError(f"seed is {seed!r}; expected a whole number from 0")
    late = Lag.of(lag)
    named, own = own_filters(filters)
    names = check_names(named)
    chosen: Any = scenario
    if not isinstance(scenario, Scenario):
        text = os.fspath(scenario)
        folder = is_archive(text)
        if folder or os.path.isfile(text):
            names = with_default(names, kind)
            from .recorded import race_on_file
            from .truth_file import has_truth, recorded_truth

            if not folder and has_truth(text):
                from .simulated import race

                source = recorded_truth(text, kind, runs, seed)
                return race(source, names, runs, seed, more=own, progress=progress, lag=late)
            if late:
                raise InputError(f"lag is {late}; expected none without truth, where filters are scored on predictions")
            return race_on_file(text, names, kind=kind, columns=columns, seed=seed, more=own, progress=progress)
        if text not in SCENARIOS:
            check_named(text)
        try:
            chosen = by_name(text)
        except ValueError as error:
            raise InputError(str(error)) from None
    from .simulated import race

    return race(chosen, names, runs, seed, more=own, progress=progress, lag=late)
