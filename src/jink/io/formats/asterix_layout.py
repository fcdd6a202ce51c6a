"""What stands in ASTERIX records of categories 048, 062 and 021: every data item's name and length.

Sources: EUROCONTROL-SPEC-0149 part 4 (CAT048, edition 1.21 and later), part 9 (CAT062, 1.18 and later) and part 12
(CAT021, 2.1 and later). A length is a number of octets; `FX` octets that go on while their last bit is set; `Rep(n)` a
count and so many times n octets; `LENGTH` an item that tells its own; `Compound` a field that says which parts follow.
"""

from __future__ import annotations

from ...frozen import frozen

FX, LENGTH = "fx", "length"


@frozen
class Rep:
    """A count of one octet, and so many times `octets`."""

    octets: int


@frozen
class Extended:
    """`octets` at a time, which go on while the last bit of the last one is set."""

    octets: int


@frozen
class Compound:
    """Parts in the order of the bits that announce them, seven to an octet."""

    parts: tuple[Layout, ...]


Layout = int | str | Rep | Extended | Compound
Item = tuple[str, Layout] | None  # None: spare

_CAT048: tuple[Item, ...] = (
    *(("010", 2), ("140", 3), ("020", FX), ("040", 4), ("070", 2), ("090", 2), ("130", Compound((1,) * 7))),
    *(("220", 3), ("240", 6), ("250", Rep(8)), ("161", 2), ("042", 4), ("200", 4), ("170", FX)),
    *(("210", 4), ("030", FX), ("080", 2), ("100", 4), ("110", 2), ("120", Compound((2, Rep(6)))), ("230", 2)),
    *(("260", 7), ("055", 1), ("050", 2), ("065", 1), ("060", 2), ("SP", LENGTH), ("RE", LENGTH)),
)
_DERIVED = Compound(
    (
        *(3, 6, 2, 2, 2, 2, 2, FX, Rep(15), 2, 2, 7, 2, 2),
        *(2, 2, 2, 2, 1, 8, 1, 6, 2, 1, Rep(8), 2, 2, 2),
    )
)
_FLIGHT_PLAN = Compound((2, 7, 4, 1, 4, 1, 4, 4, 3, 2, 2, Rep(4), 6, 1, 7, 7, 2, 7))
_CAT062: tuple[Item, ...] = (
    *(("010", 2), None, ("015", 1), ("070", 3), ("105", 8), ("100", 6), ("185", 4)),
    *(("210", 2), ("060", 2), ("245", 7), ("380", _DERIVED), ("040", 2), ("080", FX)),
    ("290", Compound((1, 1, 1, 1, 2, 1, 1, 1, 1, 1))),
    *(("200", 1), ("295", Compound((1,) * 31)), ("136", 2), ("130", 2), ("135", 2), ("220", 2), ("390", _FLIGHT_PLAN)),
    *(("270", FX), ("300", 1), ("110", Compound((1, 4, 6, 2, 2, 1, 1))), ("120", 2), ("510", Extended(3))),
    *(("500", Compound((4, 2, 4, 1, 1, 2, 2, 1))), ("340", Compound((2, 4, 2, 2, 2, 1)))),
    *(None, None, None, None, None, ("RE", LENGTH), ("SP", LENGTH)),
)
_CAT021: tuple[Item, ...] = (
    *(("010", 2), ("040", FX), ("161", 2), ("015", 1), ("071", 3), ("130", 6), ("131", 8)),
    *(("072", 3), ("150", 2), ("151", 2), ("080", 3), ("073", 3), ("074", 4), ("075", 3)),
    *(("076", 4), ("140", 2), ("090", FX), ("210", 1), ("070", 2), ("230", 2), ("145", 2)),
    *(("152", 2), ("200", 1), ("155", 2), ("157", 2), ("160", 4), ("165", 2), ("077", 3)),
    *(("170", 6), ("020", 1), ("220", Compound((2, 2, 2, 1))), ("146", 2), ("148", 2)),
    *(("110", Compound((FX, Rep(15)))), ("016", 1), ("008", 1), ("271", FX), ("132", 1), ("250", Rep(8))),
    *(("260", 7), ("400", 1), ("295", Compound((1,) * 23)), None, None, None, None, None, ("RE", LENGTH)),
    ("SP", LENGTH),
)
CATEGORIES: dict[int, tuple[Item, ...]] = {48: _CAT048, 62: _CAT062, 21: _CAT021}


class Damaged(ValueError):
    """A record that does not fit its layout."""


def record(data: bytes, at: int, items: tuple[Item, ...]) -> tuple[dict[str, bytes], int]:
    """The items of the record at `at` by name, and where it ends. Raises Damaged."""
    present, at = _announced(data, at)
    found: dict[str, bytes] = {}
    for number in present:
        item = items[number] if number < len(items) else None
        if item is None:
            raise Damaged(f"announces item {number + 1}, which the category does not have")
        end = _end(data, at, item[1])
        found[item[0]] = data[at:end]
        at = end
    return found, at


def parts_of(data: bytes, layout: Compound) -> dict[int, bytes]:
    """The parts of a compound item by their number, from 1. Raises Damaged."""
    present, at = _announced(data, 0)
    found = {}
    for number in present:
        end = _end(data, at, layout.parts[number])
        found[number + 1] = data[at:end]
        at = end
    return found


def _announced(data: bytes, at: int) -> tuple[list[int], int]:
    """The numbers of the set bits, seven to an octet, from 0, and where these octets end."""
    present: list[int] = []
    base = 0
    while True:
        if at >= len(data):
            raise Damaged("ends too early")
        octet = data[at]
        at += 1
        present += [base + bit for bit in range(7) if octet & (0x80 >> bit)]
        if not octet & 1:
            return present, at
        base += 7


def _end(data: bytes, at: int, layout: Layout) -> int:
    """Where an item ends. Raises Damaged."""
    if isinstance(layout, int):
        end = at + layout
    elif isinstance(layout, Compound):
        present, end = _announced(data, at)
        for number in present:
            if number >= len(layout.parts):
                raise Damaged(f"announces part {number + 1} of an item that has {len(layout.parts)}")
            end = _end(data, end, layout.parts[number])
    elif isinstance(layout, Rep):
        end = at + 1 + layout.octets * (data[at] if at < len(data) else 0)
    elif layout == LENGTH:
        end = at + (data[at] if at < len(data) else 0)
        if end == at:
            raise Damaged("has an item of no length")
    else:
        step = layout.octets if isinstance(layout, Extended) else 1
        end = at + step
        while end <= len(data) and data[end - 1] & 1:
            end += step
    if end > len(data):
        raise Damaged("ends too early")
    return end
