"""Frozen dataclasses do what those of the standard library do."""

from __future__ import annotations

import pickle
from dataclasses import FrozenInstanceError, dataclass, field, fields, replace
from typing import Any

import pytest

from jink.frozen import frozen


def _classes(made: Any, named: Any) -> tuple[Any, Any]:
    """A class and one derived from it."""

    @made
    class Pair:
        a: int
        b: tuple[int, ...] = ()
        c: int = field(default=0, compare=False)
        d: int = field(default=0, repr=False)

    @named
    class More(Pair):
        e: str = "e"

        def __repr__(self) -> str:
            return "more"

    return Pair, More


OURS = _classes(frozen, frozen(kw_only=True))
THEIRS = _classes(dataclass(frozen=True), dataclass(frozen=True, kw_only=True))


@pytest.mark.parametrize("k", [0, 1])
def test_like_the_standard_ones(k):
    ours, theirs = OURS[k], THEIRS[k]
    assert [f.name for f in fields(ours)] == [f.name for f in fields(theirs)]
    assert repr(ours(1, (2,))) == repr(theirs(1, (2,)))
    for first, second in (((1,), (1,)), ((1,), (2,)), ((1, (2,), 3), (1, (2,), 4)), ((1, (), 0, 1), (1,))):
        assert (ours(*first) == ours(*second)) == (theirs(*first) == theirs(*second))
        assert (hash(ours(*first)) == hash(ours(*second))) == (hash(theirs(*first)) == hash(theirs(*second)))
    assert ours(1) != theirs(1)
    assert replace(ours(1), a=2) == ours(2)
    with pytest.raises(FrozenInstanceError):
        ours(1).a = 2
    with pytest.raises(FrozenInstanceError):
        del ours(1).a
    with pytest.raises(FrozenInstanceError):
        ours(1).new = 2


def test_of_one_class_only_and_with_its_own_equality():
    pair, more = OURS
    assert pair(1) != more(1)

    @frozen(eq=False)
    class Itself:
        a: int

    assert Itself(1) != Itself(1)
    assert len({Itself(1), Itself(1)}) == 2

    @frozen
    class Parity:
        a: int

        def __eq__(self, other: object) -> bool:
            return isinstance(other, Parity) and self.a % 2 == other.a % 2

    assert Parity(1) == Parity(3)
    assert hash(Parity(1)) == hash(Parity(1))


def test_pickled():
    from jink import Position

    assert pickle.loads(pickle.dumps(Position(sd=3.0))) == Position(sd=3.0)
