"""Every public function with arguments that its hints allow, and with others: an answer, or an error that names one."""

from __future__ import annotations

import contextlib
import inspect
import re
import warnings
from datetime import datetime

import numpy as np
import public_calls
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

EXAMPLES = 18
# counts for which something as large is made
SIZES = {"n", "points", "runs", "hypotheses", "history", "updates", "repetitions", "count"}
NUMBERS = st.sampled_from([0.0, -0.0, -1.0, 0.5, 1.0, 1e-300, 5e-324, 1e150, 1e300, -1e300, np.nan, np.inf, -np.inf, 2])
WHOLE = st.sampled_from([-1, 0, 1, 2, 3, 7, 64, 513])
LARGE = st.sampled_from([2**31, 2**63, -(2**63), 10**400])
TEXTS = st.one_of(st.sampled_from(["", "x", "nan", "\udcff", "\0", "a,b=1"]), st.text(max_size=4))
OTHERS = st.sampled_from([None, True, "x", b"x", [], {}, [[]], object(), [None], ["a"], {"a": 1}, datetime(2026, 1, 1)])
ODD_ARRAYS = st.sampled_from(
    [
        [],
        [[]],
        [1, [2, 3]],
        [np.nan],
        [None, 1.0],
        ["a"],
        np.zeros((0, 2)),
        np.ones((3, 3, 3)),
        np.array(3),
        1.0,
        [1e300],
    ]
)


@st.composite
def arrays_like(draw, valid):
    """An array that is taken, with a number changed, cut, turned, of another type or one axis more; or another one."""
    array = np.array(valid, dtype=float)
    kind = draw(st.integers(0, 5))
    if array.size == 0 or kind == 0:
        return draw(ODD_ARRAYS)
    if kind == 1:
        return array[: draw(st.integers(0, len(array)))] if array.ndim else array[None]
    if kind == 2:
        return array.T[None] if draw(st.booleans()) else array.T
    if kind == 3:
        return array.astype(draw(st.sampled_from([object, str, complex, np.float32, bool, "M8[s]"])))
    array.flat[draw(st.integers(0, array.size - 1))] = draw(NUMBERS)
    return array


def values(name: str, hint: str, valid: object) -> st.SearchStrategy:
    """What to try for an argument, by its hint, its name and a value that is taken."""
    found = [OTHERS]
    if re.search(r"float|PerAxis|Time|Any", hint):
        found.append(NUMBERS)
    if re.search(r"\bint\b|PerAxis", hint):
        found += [WHOLE] if name in SIZES else [WHOLE, LARGE]
    if re.search(r"str|Literal|Path|Name", hint):
        found.append(TEXTS)
    if re.search(r"Array|Sequence|PerAxis|Iterable|Any", hint):
        whole = [] if isinstance(valid, str | None) or callable(valid) else valid
        try:
            np.array(whole, dtype=float)
        except (TypeError, ValueError):
            whole = []
        found.append(arrays_like(whole))
    return st.one_of(found)


def hints_of(call) -> dict[str, str]:
    parameters = inspect.signature(call).parameters.values()
    return {
        p.name: "Any" if p.annotation is p.empty else str(p.annotation)
        for p in parameters
        if p.kind not in (p.VAR_KEYWORD, p.VAR_POSITIONAL)
    }


@pytest.fixture(autouse=True, scope="module")
def elsewhere(tmp_path_factory):
    """Some arguments are names of files that are written: not into the folder that the tests are run from."""
    with contextlib.chdir(tmp_path_factory.mktemp("written")):
        yield


@pytest.fixture(scope="module")
def calls(tmp_path_factory):
    folder = tmp_path_factory.mktemp("public")
    return public_calls.classes() | public_calls.functions(folder) | public_calls.methods(folder)


def names_one(message: str, names: list[str]) -> bool:
    """Whether a message has one of the arguments' names, also as an option of the command line is written.

    A live target's ``t`` is a time in words; the graph of modes is that of a transition.
    """
    said = message.replace("--", " ").replace("-", "_")
    return any(re.search(rf"\b{name}\b", said) for name in names)


def check(call, given, names) -> None:
    """Errors: AssertionError unless the call ends in an answer or an error that names an argument."""
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            call(**given)
    except (ValueError, TypeError) as error:
        assert names_one(str(error), names), f"{type(error).__name__}: {error}"
    except OSError:
        assert {"path", "data", "state"} & given.keys()


def test_every_public_name_is_tried(calls):
    tried = {name.rpartition(".")[2] for name in (*calls, *public_calls.EXEMPT)}
    assert public_calls.public_names() - tried == set(public_calls.RESULTS)


def test_what_is_made_of_the_arguments_that_are_taken_is_an_answer(calls):
    for call, taken in calls.values():
        call(**taken)


def tried(call, taken) -> None:
    """Some examples, each with one argument or two that are not those that are taken."""
    hints = hints_of(call)

    @settings(max_examples=EXAMPLES)
    @given(st.data())
    def example(data):
        changed = data.draw(st.lists(st.sampled_from(sorted(hints)), min_size=1, max_size=2, unique=True))
        given = taken | {key: data.draw(values(key, hints[key], taken.get(key))) for key in changed}
        check(call, given, [*hints, "time", "graph"])

    example()


def test_an_answer_or_an_error_that_names_the_argument(calls, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # some calls save files, under any names
    for call, taken in calls.values():
        tried(call, taken)
