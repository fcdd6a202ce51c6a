"""The scripts of a user, whose types `make lint` checks strictly, do what they say."""

from pathlib import Path
from typing import get_args

import user_script
import user_script_tracks

import jink
from jink.catalogue.names import FilterName, KindName
from jink.catalogue.registry import SHORT


def test_the_users_script_runs():
    assert set(user_script.main()) == {"kalman", "imm"}


def test_tracks_races_and_live_targets(tmp_path: Path) -> None:
    for page in user_script_tracks.main(tmp_path):
        assert page.stat().st_size > 50_000


def test_names_for_type_checkers_are_the_registries():
    assert set(get_args(KindName)) == set(jink.KINDS)
    assert set(get_args(FilterName)) == {*jink.FILTERS, *SHORT}
