"""Inputs that fuzzing found, or that once led to a fault: each is read, or refused in words.

The first word of a file's name is the target of ``python -m benchmarks.fuzz`` that it belongs to.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks import fuzz

CORPUS = Path(__file__).resolve().parents[1] / "corpus"


@pytest.mark.parametrize("name", sorted(path.name for path in CORPUS.iterdir()))
def test_an_input_of_the_corpus_leads_to_no_fault(tmp_path, name):
    fuzz.TARGETS[name.partition("-")[0]]((CORPUS / name).read_bytes(), tmp_path)


def test_what_fuzzing_begins_with_is_read(tmp_path):
    for target in ("asterix", "ais", "lines", "filter"):
        assert all(fuzz.TARGETS[target](content, tmp_path) for content in fuzz.seeds(target)), target
    assert sum(fuzz.TARGETS["read"](content, tmp_path) for content in fuzz.seeds("read")) > 20
    assert all(len(content) <= fuzz.LARGEST for content in fuzz.seeds("lines"))
