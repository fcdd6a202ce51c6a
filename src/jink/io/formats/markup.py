"""XML read element by element, without its namespaces; what would expand into much more than it is, is refused."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from xml.etree import ElementTree

from ..errors import InputError


def elements(file: str, content: bytes) -> Iterator[tuple[str, str, ElementTree.Element]]:
    """`start` or `end`, the name without its namespace, and the element, in the order of the file.

    Errors: InputError where a document declares entities of its own, or is broken (said at its end).
    """
    if b"<!ENTITY" in content:
        raise InputError(f"{file} declares XML entities, which positions do not need; remove them first")
    try:
        for event, element in ElementTree.iterparse(io.BytesIO(content), events=("start", "end")):
            yield event, local(element.tag), element
    except ElementTree.ParseError as error:
        raise InputError(f"{file} is XML that cannot be read (truncated or damaged?): {error}") from None


def rooted(head: bytes, name: bytes) -> bool:
    """Whether the first element of a document has this name, in any namespace."""
    before = rb"(?:<\?.*?\?>|<!--.*?-->|<!DOCTYPE[^\[>]*(?:\[.*?\])?\s*>|\s)*"
    return re.match(before + rb"<(?:\w+:)?" + name + rb"\b", head, re.DOTALL) is not None


def local(tag: str) -> str:
    """A name without its namespace."""
    return tag.rpartition("}")[2]


def text_of(element: ElementTree.Element, name: str) -> str | None:
    """The text of the first element of that name below this one; None if there is none."""
    for child in element.iter():
        if local(child.tag) == name and child.text and child.text.strip():
            return child.text.strip()
    return None


def numbered(name: str, seen: dict[str, int]) -> str:
    """A name that is used again gets a number, so that two tracks stay two."""
    seen[name] = seen.get(name, 0) + 1
    return name if seen[name] == 1 else f"{name} ({seen[name]})"
