"""Which of the installed instruction-set levels is taken."""

import pytest

import jink
from jink import _engine, _processor


@pytest.mark.parametrize(
    ("installed", "most", "wanted", "taken"),
    [
        (["v2", "v3", "v4"], "v4", None, "v4"),
        (["v2", "v3", "v4"], "v3", None, "v3"),
        (["v4"], "v4", None, "v4"),
        (["v2", "v4"], "v3", None, "v2"),
        (["v2", "v3", "v4"], "v4", "v2", "v2"),
        (["baseline"], "baseline", None, "baseline"),
    ],
)
def test_the_best_installed_level_is_taken(installed, most, wanted, taken):
    assert _engine._choose(installed, most, wanted) == taken


@pytest.mark.parametrize(
    ("installed", "most", "wanted", "words"),
    [
        ([], "v4", None, "compiled engine is missing"),
        (["v4"], "v3", None, "built for v4, and this processor runs v3 at most"),
        (["v4"], "v4", "v2", "expected one of v4, .* got 'v2'; for other levels: make install LEVELS=all"),
        (["v2", "v3", "v4"], "v3", "v4", "expected one of v2, v3, .* got 'v4'"),
        (["v2"], "v4", "fast", "got 'fast'"),
    ],
)
def test_what_cannot_be_taken_is_explained(installed, most, wanted, words):
    with pytest.raises(ImportError, match=words):
        _engine._choose(installed, most, wanted)


@pytest.mark.parametrize(
    ("missing", "level"),
    [(set(), "v4"), ({"avx512vl"}, "v3"), ({"avx2"}, "v2"), ({"sse4_2"}, "v2")],
)
def test_the_processor_runs_what_its_flags_say(monkeypatch, missing, level):
    flags = set().union(*_processor.LEVELS.values()) - missing
    monkeypatch.setattr(_processor, "_flags", lambda: flags)
    monkeypatch.setattr(_processor.platform, "machine", lambda: "x86_64")
    assert _processor.level() == level


def test_another_processor_has_one_level(monkeypatch):
    monkeypatch.setattr(_processor.platform, "machine", lambda: "arm64")
    assert _processor.level() == "baseline"


def test_this_machine_runs_what_it_was_given():
    assert jink._engine.level in _engine.installed
