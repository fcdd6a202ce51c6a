"""What a folder of tracks was made from and how: a plan, written first, and a manifest, written last."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..io.errors import InputError
from ..io.loading import Reading
from ..tracking.prepare import Settings
from .errors import Stopped
from .folder import MANIFEST, PLAN
from .job import versions
from .store import WORK, Store

FORMAT = 2
OURS = re.compile(rf"^({re.escape(WORK)}/.*|bucket=\d+/part\.parquet)$")
ENDS = 1 << 16  # bytes at the beginning, in the middle and at the end of a file that tell it from others


@dataclass
class Plan:
    """What is to be done: settings in words, inputs by their fingerprints, the number of buckets.

    piece: rows measured at once; first: how many of the inputs decide what holds for all.
    """

    settings: dict[str, str]
    inputs: list[dict[str, Any]]
    buckets: int
    piece: int
    first: int
    versions: dict[str, Any] = field(default_factory=versions)
    format: int = FORMAT

    def write(self, store: Store) -> None:
        """Into the store."""
        text = json.dumps(dataclasses.asdict(self), ensure_ascii=False, indent=1).encode()
        store.put(PLAN, lambda handle: handle.write(text))

    @classmethod
    def read(cls, store: Store) -> Plan | None:
        """That of the store; None where nothing is. Errors: Stopped where something else is there."""
        content = store.get(PLAN)
        others = [name for name in store.names() if not OURS.match(name)]
        if others:
            more = f" and {len(others) - 1} more" if len(others) > 1 else ""
            raise Stopped(
                f"{store.where} has other files in it ({others[0]}{more}); give a new folder, or an empty one"
            )
        if content is None:
            return None
        body = json.loads(content)
        if body.get("format") != FORMAT:
            raise Stopped(f"{store.where} is of format {body.get('format')}; this jink writes format {FORMAT}")
        return cls(**body)

    def check_alike(self, other: Plan, where: str) -> None:
        """Errors: Stopped where the plan of the store is another one than what is asked for now, with what differs."""
        for name, mine in (self.versions | self.settings).items():
            new = (other.versions | other.settings).get(name)
            if new != mine:
                raise Stopped(
                    f"{where} was made with {name} {_short(mine)}, now it is {_short(new)}; "
                    "give the same settings, or a new folder"
                )


def in_words(reading: Reading, settings: Settings) -> dict[str, str]:
    """Every setting that changes tracks, as text."""
    said = {}
    for thing in (reading, settings):
        for each in dataclasses.fields(thing):
            if each.name not in ("threads",):
                said[each.name] = _in_text(getattr(thing, each.name))
    return said


def _in_text(value: Any) -> str:
    text = repr(value)
    return text if len(text) < 200 else hashlib.sha256(text.encode()).hexdigest()


def _short(value: Any) -> str:
    return "unknown" if value is None else str(value)


def fingerprint(path: Path, name: str) -> dict[str, Any]:
    """A file's name as given, path, size, time of change and a hash of its ends. Errors: InputError."""
    try:
        state = path.stat()
        with path.open("rb") as handle:
            found = hashlib.sha256()
            for place in (0, state.st_size // 2, max(0, state.st_size - ENDS)):
                handle.seek(place)
                found.update(handle.read(ENDS))
    except OSError as error:
        raise InputError(f"{name} cannot be opened: {error.strerror}") from None
    said = {"file": name, "path": str(path.absolute()), "size": state.st_size}
    return said | {"changed": state.st_mtime_ns, "hash": found.hexdigest()}


def agreed_inputs(plan: Plan, given: Sequence[dict[str, Any]], append: bool, where: str) -> list[dict[str, Any]]:
    """The inputs of the plan and, to be appended, those that are new. Errors: Stopped."""
    known = {each["path"]: each for each in plan.inputs}
    new = []
    for each in given:
        before = known.get(each["path"])
        if before is None:
            new.append(each)
        elif before | {"file": each["file"]} != each:
            raise Stopped(f"{each['file']} has changed since {where} was begun; give a new folder")
    if append:
        return [*plan.inputs, *new]
    paths = {each["path"] for each in given}
    missing = [each["file"] for each in plan.inputs if each["path"] not in paths]
    if missing:
        raise Stopped(f"{where} was made from {missing[0]} too; give the same files, or a new folder")
    if new:
        raise Stopped(f"{new[0]['file']} is not in {where}; --append adds it")
    return plan.inputs


def finish(store: Store, body: dict[str, Any]) -> None:
    """Write the manifest: the folder is complete."""
    text = json.dumps(body, ensure_ascii=False, indent=1, default=str).encode()
    store.put(MANIFEST, lambda handle: handle.write(text))


def manifest_of(store: Store) -> dict[str, Any] | None:
    """The manifest of a complete folder."""
    content = store.get(MANIFEST)
    return None if content is None else json.loads(content)


def incomplete(path: str | Path) -> Stopped:
    """What is said of a folder without a manifest."""
    return Stopped(f"{path} is not complete (there is no {MANIFEST}); run the same jink track again")
