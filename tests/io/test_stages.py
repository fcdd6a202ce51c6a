"""Seconds by stage: inner stages count instead of outer ones, and all seconds are somewhere."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import pytest

from jink.io import stages


@pytest.fixture
def clock(monkeypatch):
    """Wall and processor seconds that a test sets."""
    now = [0.0, 0.0]
    monkeypatch.setattr(stages.Ledger, "_now", staticmethod(lambda: (now[0], now[1])))

    def tick(wall, cpu):
        now[0] += wall
        now[1] += cpu

    return tick


def test_inner_stages_count_instead_of_outer_ones(clock):
    @stages.stage("write")
    def inner():
        clock(2.0, 1.0)

    @stages.stage("table")
    def outer():
        clock(4.0, 3.0)
        inner()
        clock(8.0, 5.0)

    with stages.recorded() as ledger:
        clock(1.0, 0.5)
        outer()
    outer()  # nothing is recorded any more
    figures = ledger.figures()
    assert figures["table"] == {"wall": 12.0, "cpu": 8.0}
    assert figures["write"] == {"wall": 2.0, "cpu": 1.0}
    assert sum(figure["cpu"] for figure in figures.values()) == pytest.approx(9.5 + 9.0)
    assert figures["rest"]["cpu"] == 9.5  # before, and after the record


def test_stages_at_once_share_the_time(clock):
    ledger = stages.Ledger()
    ledger.enter("filter")
    with ThreadPoolExecutor(1) as pool:
        pool.submit(ledger.enter, "table").result()
        clock(4.0, 6.0)
        pool.submit(ledger.leave).result()
    clock(1.0, 1.0)
    ledger.leave()
    assert ledger.cpu["filter"] == 4.0 and ledger.cpu["table"] == 3.0 and ledger.cpu["rest"] == 0.0


def test_a_stage_ends_when_its_function_fails(clock):
    @stages.stage("read")
    def broken():
        clock(1.0, 1.0)
        raise ValueError("no")

    with stages.recorded() as ledger:
        with pytest.raises(ValueError, match="no"):
            broken()
        clock(1.0, 1.0)
    assert ledger.figures()["read"]["cpu"] == 1.0 and ledger.figures()["rest"]["cpu"] == 1.0
