"""Licences of what `jink[all]` brings: each must be one that MIT code can be shipped beside.

    python scripts/licences.py          of jink[all]
    python scripts/licences.py test     of another extra

Exit status 1 where a package has none, or one that is not known to be permissive (GPL, AGPL, LGPL are not). ACCEPTED
names those that are taken all the same.
"""

from __future__ import annotations

import re
import sys
import tomllib
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

KNOWN = re.compile(
    r"\b(MIT|BSD|Apache|MPL|Mozilla Public|ISC|PSF|Python Software Foundation|0BSD|Unlicense|Zlib|HPND|CC0|BSL)\b", re.I
)
MIT_TEXT = "Permission is hereby granted, free of charge, to any person obtaining a copy"
# accepted by name, with the reason
ACCEPTED = {"moocore": "LGPL, unmodified and a package of its own; pymoo brings it for `jink learn`"}
REFUSED = re.compile(r"\b(A|L)?GPL|GNU (Affero|Lesser|Library)?|\bSSPL\b|proprietary", re.I)


def needed(name: str, extras: frozenset[str], seen: set[tuple[str, frozenset[str]]]) -> Iterator[metadata.Distribution]:
    """What a package needs, and what that needs. What is not installed is left out."""
    if (name, extras) in seen:
        return
    seen.add((name, extras))
    try:
        found = metadata.distribution(name)
    except metadata.PackageNotFoundError:
        return
    yield found
    for text in found.requires or ():
        wanted = Requirement(text)
        environments = [{"extra": extra} for extra in extras or {""}]
        if wanted.marker is None or any(wanted.marker.evaluate(environment) for environment in environments):
            yield from needed(canonicalize_name(wanted.name), frozenset(wanted.extras), seen)


def licence(found: metadata.Distribution) -> str:
    """As the package states it: expression, classifiers, or its text."""
    about = found.metadata
    stated = about.get("License-Expression") or ""
    classified = [c.rpartition(" :: ")[2] for c in about.get_all("Classifier", []) if c.startswith("License ::")]
    if stated or classified:
        return stated or ", ".join(classified)
    text = (about.get("License") or "").strip()
    for file in found.files or ():
        if "LICEN" in file.name.upper():
            text += "\n" + str(found.locate_file(file).read_text())  # type: ignore[attr-defined]
    return "MIT (by its text)" if MIT_TEXT in text else text.partition("\n")[0]


def acceptable(text: str) -> bool:
    """Whether one of several licences joined by OR is permissive, and all that are joined by AND."""
    choices = re.split(r"\bOR\b", text)
    return any(KNOWN.search(choice) is not None and REFUSED.search(choice) is None for choice in choices)


def required(extra: str) -> Iterator[Requirement]:
    """What pyproject.toml asks for, extras of extras included."""
    project = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    yield from map(Requirement, project["dependencies"])
    for wanted in map(Requirement, project["optional-dependencies"][extra]):
        if wanted.name != project["name"]:
            yield wanted
            continue
        for inner in wanted.extras:
            yield from required(inner)


def main() -> int:
    """One line for each package."""
    extra = sys.argv[1] if len(sys.argv) > 1 else "all"
    seen: set[tuple[str, frozenset[str]]] = set()
    asked = list(required(extra))
    found = [d for wanted in asked for d in needed(canonicalize_name(wanted.name), frozenset(wanted.extras), seen)]
    packages = {canonicalize_name(d.name): licence(d) for d in found}
    missing = sorted({canonicalize_name(wanted.name) for wanted in asked} - packages.keys())
    wrong = [name for name, text in packages.items() if not acceptable(text) and name not in ACCEPTED]
    for name, text in sorted(packages.items()):
        why = "" if acceptable(text) else f" ({ACCEPTED[name]})" if name in ACCEPTED else ""
        print(f"{'REFUSED' if name in wrong else 'ok':>8}  {name:<24} {text or 'no licence stated'}{why}")
    for name in missing:
        print(f"{'MISSING':>8}  {name:<24} not installed, so nothing is known of it")
    print(f"{len(packages)} packages of jink[{extra}], {len(wrong)} refused, {len(missing)} missing")
    return int(bool(wrong or missing))


if __name__ == "__main__":
    sys.exit(main())
