"""The benchmark's plumbing on tiny sizes: every job runs, every row is built; no timing is asserted."""

from __future__ import annotations

import shutil
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks import (
    cases,
    child,
    commands,
    engine,
    gradients,
    learning,
    peers,
    race,
    ratios,
    reference,
    reference_kernel,
    sky_race,
    stages,
    table,
    targets,
)


@pytest.fixture(scope="module")
def results() -> dict:
    """All in-process tasks at tiny size, without other libraries."""
    return {
        "v4": child.run_engine(child.TINY),
        "fresh": child.run_fresh(child.TINY),
        "peers": child.run_peers(child.TINY, keys=()),
        "skies": child.run_skies(child.TINY),
        "threads": child.run_threads(child.TINY),
        "memory, states": child.run_memory(child.TINY, "STATES"),
        "memory, everything": child.run_memory(child.TINY, "EVERYTHING"),
        "track": {"error": "no network"},
        "compare": commands.measure_compare(1, 3, "choi-2001-1"),
        "compare, long": {"error": "interrupted"},
        "start": {"numpy": [0.1], "jink": [0.12], "help": [0.2]},
    }


def test_the_race_of_ten_filters_is_a_row(results):
    row = next(row for row in targets.rows(results) if "ten filters" in row.what)
    assert "interrupted" in row.measured and row.reached is None
    rows = targets.rows({**results, "compare, long": results["compare"]})
    row, memory = (next(row for row in rows if words in row.what) for words in ("ten filters", "more runs"))
    assert "s of CPU" in row.measured and row.reached is not None
    assert memory.reached and "MB against" in memory.measured


def test_every_target_of_the_table_has_a_row(results):
    rows = targets.rows(results)
    assert len(rows) >= 20
    measured = [row for row in rows if row.reached is not None]
    assert {"`import jink`", "`jink --help`"} <= {row.what for row in measured}
    assert any("no network" in row.measured and row.reached is None for row in rows)


def test_jink_does_the_peers_jobs_exactly(results):
    for job in peers.JOBS:
        assert results["peers"][job]["jink"]["difference"] < 1e-9, job


def part(rows, processor="x", kind="tiny"):
    return table.part({"Processor": processor, "Python": "3"}, kind, table.target_table(rows), rows)


def test_report_is_a_table_with_marks(results):
    rows = targets.rows(results)
    text = part(rows)
    assert text.startswith("## x: tiny\n") and all(f"| {row.what}" in text for row in rows)
    for words in ("not measured", "pass"):
        assert words in text
    assert any("not installed" in line for line in table.peer_table(results["peers"]))


def test_nothing_measured_still_reports():
    rows = targets.rows({})
    assert all(row.reached is None for row in rows)
    assert part(rows)


def test_a_report_keeps_the_parts_of_other_machines():
    one, other = targets.Row("a", "1 ns", "≤ 2 ns", True), targets.Row("b", "3 ns", "≤ 2 ns", False)
    text = table.with_part("", part([one], "here"))
    text = table.with_part(text, part([one], "there"))
    text = table.with_part(text, part([one], "here", "ratios"))
    again = table.with_part(text, part([other], "here"))
    titles = [line for line in again.splitlines() if line.startswith("## ")]
    assert titles == ["## here: tiny", "## there: tiny", "## here: ratios", table.HOW[0]]
    here, there, third = (again.split(title)[1].split("## ")[0] for title in titles[:3])
    assert "| b " in here and "| a " not in here and "1 short" in here
    assert "| a " in there and "| a " in third
    assert table.with_part(again, part([other], "here")) == again


def test_ratios_are_rows():
    found = child.run_ratios(child.TINY)["ratios"]
    rows = ratios.rows(found)
    assert sorted(row.what for row in rows) == sorted(
        [*(pair.what for pair in ratios.pairs(3, 5)), ratios.AGAINST_KERNEL]
    )
    measured = [row for row in rows if "no C++ compiler" not in row.measured]
    assert len(measured) >= 6
    assert all(" × " in row.measured and (row.reached is not None) == bool(row.must) for row in measured)
    found[0] |= {"dear": [5.0], "cheap": [1.0]}
    found[1] |= {"dear": [3.0], "cheap": [1.0]}
    assert [row.reached for row in ratios.rows(found)][:2] == [False, True]


@pytest.mark.skipif(not shutil.which("c++") and not shutil.which("g++"), reason="there is no C++ compiler")
def test_the_hand_written_kernel_answers_as_jink_does():
    case = cases.regular(11, 70)
    job = ratios.kernel_pair(11, 70).dear
    estimate = job.run(None)
    reference_kernel.check(case, estimate.x, estimate.log_likelihood)
    states, _ = reference.imm(case.first(2, 40))
    assert race.difference(estimate.x.reshape(11, 70, 4)[:2, :40], states) < targets.SAME
    with pytest.raises(RuntimeError, match="differs from jink by"):
        reference_kernel.check(case, estimate.x, estimate.log_likelihood * (1 + 1e-6))


def test_a_kernel_that_cannot_be_built_is_no_figure(monkeypatch):
    monkeypatch.setenv("CXX", "/bin/false")
    reference_kernel.library.cache_clear()
    with pytest.raises(RuntimeError, match="reference kernel: /bin/false"):
        reference_kernel.library()
    row = ratios.rows([{"what": ratios.AGAINST_KERNEL, "most": 1.3, "error": "found no C++ compiler"}])[0]
    assert row.measured == "not measured: found no C++ compiler" and row.reached is None


def test_stages_are_rows():
    found = stages.measure(1, copies=1)
    rows = stages.rows(found)
    assert len(rows) == len(stages.LIMITS) + len(stages.WHOLE)
    assert all("µs of CPU a row" in row.measured and row.reached is not None for row in rows)
    cheap = {name: 0.0 for name in found["csv"][0]}
    assert stages.rows({"csv": [cheap | {"filter": 9.0}]})[0].reached
    assert not stages.rows({"csv": [cheap | {"write": 9.0}]})[0].reached


def test_a_missing_peer_is_shown_as_not_installed():
    module, why = peers.load("no_such_library")
    assert module is None and why.startswith("not installed")
    shown = {
        "kalman": {
            "jink": {"costs": [1.0], "difference": 0.0},
            "absent": {"missing": why},
            "unable": {"cannot": "no IMM"},
        }
    }
    lines = table.peer_table(shown)
    assert any("absent" in line and "not installed" in line for line in lines)
    assert any("unable" in line and "cannot" in line and "no IMM" in line for line in lines)


def test_race_interleaves_and_compares_round_by_round():
    order: list[str] = []
    jobs = {name: race.Job(lambda _, name=name: order.append(name), updates=1) for name in "ab"}
    laps = race.run_race(jobs, 2)
    assert order == ["a", "b", "a", "b", "b", "a"]
    assert {len(lap.costs) for lap in laps.values()} == {2}
    ratio = race.compare(race.Lap((2.0, 6.0)), race.Lap((1.0, 2.0)))
    assert (ratio.median, ratio.low, ratio.high) == (2.5, 2.0, 3.0)


def test_textbook_imm_with_one_mode_is_the_kalman_filter():
    case = cases.regular(2, 12)
    single = replace(case, Q=case.Q[:1], transition=np.eye(1), mode_probability=np.ones(1))
    states, probability = reference.imm(single)
    assert np.allclose(states, reference.kalman(single), rtol=1e-12, atol=1e-9)
    assert (probability == 1).all()


def test_trainings_are_rows():
    """A hundredth of every training runs; a limit is reached by what was measured."""
    results = {"learning": child.run_learning(child.TINY)}
    rows = learning.rows(results)
    assert len(rows) == 4 and all(row.reached is not None and "s of CPU" in row.measured for row in rows)
    slow = {name: {"seconds": [1.0], "cpu": [limit + 0.1]} for name, limit in learning.LIMITS.items()}
    assert not any(row.reached for row in learning.rows({"learning": slow}))
    assert all("not run" in row.measured and row.reached is None for row in learning.rows({}))


def test_jobs_without_a_peer_follow_what_is_measured():
    """CV + CA and CV + CT estimates stay near the measurements: the models and the polar sensor fit the data."""
    holey, uneven = cases.irregular(8, 100), cases.irregular(8, 100, missing=0.0)
    for case, job, y in ((holey, engine.mixed(holey), 3), (uneven, engine.turning(uneven), 2)):
        x = job.run(job.prepare())
        away = np.hypot(*(x[:, :, [0, y]] - case.measurements()).transpose(2, 0, 1))
        assert np.isfinite(x).all()
        assert np.nanmedian(away) < 5 * cases.POSITION_SD


def test_gradients_are_a_row_and_its_value_is_the_filters():
    """The value with the derivatives is the log-likelihood; they are differences of it."""
    job = gradients.jobs(3, 5)
    both = job[gradients.SLOPES].run(None)
    np.testing.assert_allclose(both[0], job[gradients.VALUE].run(None), rtol=1e-10)
    assert both.shape == (1 + gradients.DERIVATIVES, 3)
    row = gradients.rows({"gradients": child.run_gradients(child.TINY)})[0]
    assert "ms" in row.measured and row.reached is not None
    assert "not run" in gradients.rows({})[0].measured


def test_the_race_on_whole_skies_is_a_table(results):
    text = "\n".join(sky_race.table_of(**results["skies"]))
    assert "| sky-crossing | jink" in text


def test_a_lost_race_on_a_sky_is_said():
    found = {"jink": {"gospa": 2.0, "ms": 1.0, "scans": 3}}
    found["Stone Soup, GNN"] = {"gospa": 1.8, "gospa ratio": 0.9, "ms": 500.0, "time ratio": 500.0, "scans": 3}
    text = "\n".join(sky_race.table_of({"sky-regional": found}, {"stonesoup": "1.9"}))
    assert "MISS sky-regional: Stone Soup, GNN has the better GOSPA, 0.900 of jink's" in text
    assert "takes 500 × jink's time, wanted 1000" in text
