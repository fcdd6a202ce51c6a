"""Which filter `jink.track` takes where none is named: aircraft get the learned correction of what is filtered."""

from __future__ import annotations

from pathlib import Path

import pytest
from polars.testing import assert_frame_equal

import jink
from jink.catalogue.choose import PROVEN
from jink.catalogue.corrected import CORRECTED

RADAR = Path(__file__).parents[2] / "examples" / "radar.csv"


@pytest.mark.parametrize(
    ("kind", "how", "name"),
    [
        ("aircraft", {}, "imm-corrected"),
        ("aircraft", {"velocity": False}, "imm-corrected"),
        ("aircraft", {"smooth": True}, "imm"),
        ("aircraft", {"lag": 2}, "imm"),
        ("fighter", {}, "imm-corrected"),
        ("fighter", {"smooth": True}, "imm"),
        ("vessel", {}, "imm"),
    ],
)
def test_the_default_is_a_name_too(kind, how, name):
    own, named = (jink.track(RADAR, kind=kind, filter=f, details=True, **how) for f in (None, name))
    assert_frame_equal(own.tracks, named.tracks)
    assert own.summary["filter"] == named.summary["filter"]
    assert not any("learned correction" in note for note in own.summary["notes"])


def test_the_correction_is_one_that_the_other_filter_lacks():
    assert set(PROVEN) <= set(CORRECTED)
    assert not jink.track(RADAR)["x"].equals(jink.track(RADAR, filter="imm")["x"])
