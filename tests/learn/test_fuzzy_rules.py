"""Fuzzy rules: the equation, what happens far from every centre, units, words."""

from __future__ import annotations

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from oracle.fuzzy import Rules

import jink
from jink.filters.fuzzy_imm import FuzzyNoise, fuzzy_imm
from jink.models.fuzzy import PUBLISHED, FuzzyRules

SENSOR = jink.Position(sd=500.0, axes=1)


def test_the_variance_is_the_mean_of_the_consequents_weighted_by_firing():
    rules = FuzzyRules(((0.0, 0.0), (2.0, -1.0)), ((1.0, 2.0), (0.5, 1.0)), (1.0, 9.0))
    r, dr = 1.5, -0.5
    h = [np.exp(-0.5 * 1.5**2 - 0.5 * 0.25**2), np.exp(-0.5 * 1.0**2 - 0.5 * 0.5**2)]
    assert_allclose(rules.variance(r, dr), (h[0] + 9 * h[1]) / sum(h), rtol=1e-14)
    assert_allclose(rules.firing(r, dr), np.array(h) / sum(h), rtol=1e-14)


@pytest.mark.parametrize("table", PUBLISHED["lee-2003"])
def test_published_tables_are_those_of_the_oracle(table):
    r, dr = np.random.default_rng(0).normal(0, 1500.0, (2, 200))
    oracle = Rules.table(table.table(unit=1000.0), length=1000.0, variance=1e6)
    assert_allclose(table.variance(r, dr), oracle.q(r, dr), rtol=1e-12)


def test_far_from_every_centre_the_nearest_rule_decides():
    table = PUBLISHED["lee-2003"][2]
    q = table.variance([20e3, -20e3, 1e9], [0.0, 0.0, 0.0])
    assert np.isfinite(q).all()
    assert (q >= min(table.variances)).all() and (q <= max(table.variances)).all()


def test_rules_are_told_in_words():
    words = PUBLISHED["lee-2003"][1].describe()
    assert len(words) == 8
    assert words[3].startswith("if r is about −1.33 km (±0.634) and Δr about −1.8 km (±1.74)")
    assert "10.7 m/s²" in words[3]


def test_a_table_in_kilometres_taken_for_metres_is_refused():
    wrong = FuzzyRules.of(PUBLISHED["lee-2003"][0].table(unit=1000.0))
    with pytest.raises(ValueError, match=r"expected metres .* FuzzyRules.of\(table, unit=1000\)"):
        fuzzy_imm(SENSOR, [wrong])
    with pytest.raises(ValueError, match="expected metres"):
        jink.Kalman(FuzzyNoise(jink.ConstantVelocity(acceleration_sd=1.0), wrong), SENSOR)


def test_a_file_in_wrong_units_is_refused(tmp_path):
    path = tmp_path / "rules.json"
    fuzzy_imm(SENSOR).save(path)
    body = json.loads(path.read_text(encoding="utf-8"))
    for motion in body["motions"]:
        for name in ("centres", "spreads"):
            motion["rules"][name] = (np.array(motion["rules"][name]) / 1000).tolist()
    path.write_text(json.dumps(body), encoding="utf-8")
    with pytest.raises(ValueError, match=r"rules\.json: FuzzyRules: the rules are about residuals"):
        jink.load(path)
    body["units"] = "km"
    path.write_text(json.dumps(body), encoding="utf-8")
    with pytest.raises(ValueError, match="units 'km'; expected SI"):
        jink.load(path)


def test_a_filter_of_rules_comes_back_from_its_file_bit_for_bit(tmp_path):
    filter, path = fuzzy_imm(SENSOR), tmp_path / "rules.json"
    filter.save(path)
    again = jink.load(path)
    assert again.motions == filter.motions
    z = np.random.default_rng(1).normal(0, 500.0, (100, 1)).cumsum(axis=0)
    assert_array_equal(again.filter(np.arange(100.0), z).x, filter.filter(np.arange(100.0), z).x)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"centres": [[0.0]]}, "expected centres"),
        ({"spreads": [[1.0, 0.0]]}, "spreads: expected positive"),
        ({"variances": [-1.0]}, "variances: expected positive"),
        ({"centres": [[np.nan, 0.0]]}, "centres: expected finite"),
        ({"variances": []}, "at least one rule"),
    ],
)
def test_rules_that_make_no_sense_are_refused(change, message):
    given = {"centres": [[0.0, 0.0]], "spreads": [[1.0, 1.0]], "variances": [1.0], **change}
    with pytest.raises(ValueError, match=message):
        FuzzyRules(**given)
