"""The example flights: manoeuvres are found, and every form of the same radar's plots gives the same answer."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from benchmarks import forms, manoeuvres  # noqa: E402
from benchmarks.flights import flights  # noqa: E402

EXAMPLE = ROOT / "examples" / "flights.parquet"


def test_manoeuvres_of_real_flights_are_found():
    found = manoeuvres.measured(EXAMPLE)
    for name, (detection, false_alarm, often) in manoeuvres.AIMS.items():
        told, alarms, segments = (found[name][each][0] for each in ("detection", "false alarm", "false segments/h"))
        assert told >= detection and alarms <= false_alarm, name
        assert often is None or segments <= often
    assert "MISSED" not in manoeuvres.said(found)


@pytest.mark.parametrize("radar", ["4 s", "1 s"])
def test_every_form_of_the_same_plots_gives_the_same_answer(radar):
    plots = forms.seen(list(flights(EXAMPLE))[:6], forms.RADARS[radar], seed=3)
    first, *others = (forms.tracked(plots, form) for form in forms.FORMS)
    for other in others:
        assert abs(forms.ratio(other, first, plots, "r99")[0] - 1.0) < 0.02
    assert first.lost(plots) == 0.0
    # a smoothed position uses plots of both sides: of white noise half the variance would be left
    assert forms.ratio(forms.tracked(plots, forms.FORMS[0], smooth=True), first, plots, "r99")[0] < 0.75


def test_plots_without_heights_are_nearer_with_those_of_the_kind():
    # measured .89 with a standard error of .07: less than one is all that so few flights tell
    plots = forms.seen(list(flights(EXAMPLE)), forms.RADARS["4 s"], seed=3)
    kind, ground = (forms.tracked(plots, forms.SLANT, **how) for how in forms.HEIGHTS.values())
    assert forms.ratio(kind, ground, plots, "r99")[0] < 1.0
    assert kind.lost(plots) <= ground.lost(plots)
