"""A search on disk: where it stands, and of which data, so that it can be stopped and taken up again."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from ..filters.plain import write
from ..frozen import frozen
from ..io.errors import InputError
from ..models.tracks import Tracks
from .objectives import Objective
from .optimise import State
from .parameters import Parameters


@frozen
class Checkpoint:
    """A file for the states of one search; ``print`` identifies its data, filter and objective."""

    path: Path
    print: dict[str, Any]

    @classmethod
    def of(
        cls,
        path: str | Path | None,
        parameters: Parameters,
        objective: Objective,
        tracks: Tracks,
        seed: int,
        starts: int,
    ) -> Checkpoint | None:
        """The checkpoint of a search, or None without a path."""
        if path is None:
            return None
        digest = hashlib.sha256()
        for name in ("time", "z", "offsets", "covariance", "truth", "counts"):
            array = getattr(tracks, name)
            if array is not None:
                digest.update(np.ascontiguousarray(array).tobytes())
        start = [round(float(u), 9) for u in parameters.start]
        what = {"data": digest.hexdigest(), "objective": repr(objective), "seed": seed, "starts": starts}
        return cls(Path(path), {**what, "parameters": list(parameters.names), "start": start})

    def write(self, state: State) -> None:
        """Keep a state, whole or not at all."""
        write({"jink": "fit checkpoint", "search": self.print, "state": asdict(state)}, self.path)

    def read(self) -> State:
        """The state kept. Errors: InputError where it is not a state, or differs from this search, naming in what."""
        try:
            body = json.loads(self.path.read_text(encoding="utf-8"))
            search, state = body["search"], State(**body["state"])
            if not all(isinstance(n, int) for n in (state.stage, state.evaluations)):
                raise TypeError
        except FileNotFoundError:
            raise InputError(
                f"checkpoint {self.path} does not exist, so the fit cannot resume; start it without --resume"
            ) from None
        except (ValueError, KeyError, TypeError, UnicodeDecodeError):
            raise InputError(
                f"{self.path} does not hold a checkpoint of jink fit; start again without --resume"
            ) from None
        other = [name for name, value in self.print.items() if search.get(name) != value]
        if other:
            raise InputError(
                f"checkpoint {self.path} was written by a fit with different {' and '.join(other)}; "
                "repeat that fit's options, or start a new fit without --resume"
            )
        return state
