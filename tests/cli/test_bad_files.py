"""Filter files that make no sense end `jink track --filter FILE` with status 2, one line that names the entry, and no
output.
"""

from __future__ import annotations

import copy
import json
import random
from functools import partial
from pathlib import Path

import pytest
from subjects import NAMED, build
from typer.testing import CliRunner

import jink
from jink.catalogue.purpose import Purpose
from jink.catalogue.registry import FILTERS
from jink.cli.main import app
from jink.filters.loading import read

CV, CA = jink.ConstantVelocity(acceleration_sd=1.0), jink.ConstantAcceleration(jerk_psd=1.0)
LEVELS = [jink.ConstantVelocity(acceleration_sd=sd) for sd in (1.0, 3.0, 9.0, 27.0)]
FLIGHTS = Path(__file__).parents[2] / "examples" / "flights.parquet"
SPACE = jink.Position(sd=25.0, axes=3)
FUZZY = jink.CurrentStatistical(limits=jink.FuzzyLimits(threshold=7.5, operating=6.75))


def saved(filter, tmp_path) -> dict:
    filter.save(tmp_path / "filter.json")
    return json.loads((tmp_path / "filter.json").read_text())


def three_axes(name):
    """A registered filter for what the example flights have."""
    return lambda: FILTERS[name](Purpose(sensor=SPACE, kind="aircraft")).filter


FILES = {  # a filter, a change of its file, and what is said of it
    "operating": (
        partial(jink.Kalman, FUZZY, SPACE),
        ("motions", 0, "limits", "operating"),
        8.0,
        "motions[0].limits: FuzzyLimits.operating: expected a value below the threshold 7.5",
    ),
    "exponent": (
        partial(jink.Kalman, FUZZY, SPACE),
        ("motions", 0, "limits", "up"),
        1.2,
        "motions[0].limits: FuzzyLimits.up: expected at most 1.0536, got 1.2",
    ),
    "graph": (
        partial(jink.DigraphSwitching, LEVELS, SPACE, 0.9),
        ("graph",),
        [[1], [0], [3], [2]],
        "graph: mode 2 cannot be reached from mode 0",
    ),
    "transition": (
        partial(jink.GPB1, [CV, CA], SPACE, [[0.9, 0.1], [0.2, 0.8]]),
        ("transition", 1),
        [0.2, 0.9],
        "transition: transition[i, j] = p(j | i), so each row must sum to one",
    ),
    "transition of words": (
        partial(jink.GPB1, [CV, CA], SPACE, 0.9),
        ("transition",),
        "often",
        "transition: expected a stay probability, a matrix or a jink.Sojourn, got 'often'",
    ),
    "estimated": (
        partial(jink.IMM, [jink.AccelerationLevel(CV, 1.0), CV], SPACE, 0.9),
        ("motions", 0, "estimated"),
        True,
        "AccelerationLevel.estimated needs the estimate",
    ),
    "rules in kilometres": (
        three_axes("fuzzy-kalman"),
        ("motions", 0, "rules"),
        {"kind": "FuzzyRules", "centres": [[0.5, 0.0]], "spreads": [[0.2, 1.0]], "variances": [1e-6]},
        "residuals up to 0.9 m, but the sensor's sd is 25 m; expected metres and (m/s²)²",
    ),
    "units": (three_axes("kalman-cv"), ("units",), "km", "units 'km'; expected SI"),
    "version": (three_axes("kalman-cv"), ("version",), 99, "has version 99; this jink reads version 1"),
    "training range": (
        three_axes("anfis-kf"),
        ("corrector", "low", 0),
        1e9,
        "Corrector.low: expected to lie below high",
    ),
    "training range unknown": (
        three_axes("nn-kf"),
        ("corrector", "high"),
        [1.0],
        "corrector: Corrector.high: expected",
    ),
    "a network that is not finite": (
        three_axes("nn-kf"),
        ("corrector", "model", "biases", 0, 0),
        float("nan"),
        "corrector.model: Network: layer 0 has numbers that are not finite",
    ),
    "membership functions": (
        three_axes("anfis-kf"),
        ("corrector", "model", "shape"),
        "square",
        "corrector.model: Anfis.shape: expected one of triangular, gaussian, bell, got 'square'",
    ),
    "a part of another kind": (
        partial(jink.Kalman, FUZZY, SPACE),
        ("motions", 0, "limits"),
        {"kind": "Position", "sd": 1.0},
        "CurrentStatistical.limits: expected FuzzyLimits, got Position",
    ),
    "a part of no kind": (
        partial(jink.Kalman, FUZZY, SPACE),
        ("motions", 0, "limits"),
        {"kind": "Limits"},
        "motions[0].limits: kind 'Limits' is not one of",
    ),
    "a part too many": (
        partial(jink.Kalman, FUZZY, SPACE),
        ("motions", 0, "limits", "side"),
        1.0,
        "motions[0].limits: FuzzyLimits has no argument side",
    ),
}


@pytest.mark.parametrize("what", FILES)
def test_the_command_refuses_a_file(what, tmp_path):
    make, where, value, message = FILES[what]
    body = saved(make(), tmp_path)
    changed = copy.deepcopy(body)
    at = changed
    for step in where[:-1]:
        at = at[step]
    at[where[-1]] = value
    status, _, said = track(tmp_path, json.dumps(changed))
    assert (status, said.count("\n")) == (2, 1), said
    assert "filter.json" in said and message in said


HEAD = '{"jink": "filter", "version": 1, "units": "SI"'
NO_FILTERS = [
    "",
    "{",
    "[1, 2]",
    "null",
    '"jink"',
    '{"jink": "filter"}',
    HEAD + "}",
    HEAD + ', "filter": "Kalman"}',
    "\x00\xff",
]


@pytest.mark.parametrize("text", NO_FILTERS)
def test_the_command_refuses_what_is_no_filter_file(text, tmp_path):
    status, _, said = track(tmp_path, text)
    assert status == 2 and "filter.json" in said and "Traceback" not in said


def track(tmp_path, text):
    """Status, standard output and standard error; and nothing is left behind."""
    (tmp_path / "filter.json").write_bytes(text.encode("latin-1"))
    arguments = [
        "track",
        str(FLIGHTS),
        "--filter",
        str(tmp_path / "filter.json"),
        "-o",
        str(tmp_path / "out.parquet"),
    ]
    result = CliRunner(env={"COLUMNS": "400"}).invoke(app, arguments)
    assert result.exception is None or isinstance(result.exception, SystemExit)
    assert [p.name for p in tmp_path.iterdir()] == ["filter.json"]
    return result.exit_code, result.stdout, result.stderr


DAMAGE = [
    None,
    "x",
    -1.0,
    [],
    {},
    float("inf"),
    float("nan"),
    True,
    0,
    [[1.0]],
    {"kind": "Nothing"},
    {"kind": "Sojourn"},
    10**400,
]


def places(node, path=()):
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, below in items:
        yield (*path, key)
        yield from places(below, (*path, key))


@pytest.mark.parametrize("name", NAMED)
def test_random_damage_to_a_file_is_refused_or_makes_a_filter(name, tmp_path):
    """Whatever one entry of a registered filter's file becomes: a filter, or a ValueError naming the file."""
    body = saved(build(name), tmp_path)
    rng, every = random.Random(name), list(places(body))
    refused = 0
    for _ in range(40):
        *inner, last = rng.choice(every)
        changed = copy.deepcopy(body)
        at = changed
        for step in inner:
            at = at[step]
        damage = rng.choice([*DAMAGE, "gone"])
        if damage == "gone":
            del at[last]
        else:
            at[last] = damage
        try:
            read(json.dumps(changed), "filter.json")
        except ValueError as error:
            refused += 1
            assert str(error).startswith("filter.json: ")
    assert refused > 10
