"""Processes that track an archive: the same for both stages, and replaced where they die."""

import os
import signal
import time
from contextlib import closing

import pytest

from jink.archive.errors import Stopped
from jink.archive.workers import Processes

TASKS = [(os.getpid, ())] * 6


def ended(process):
    """Whether it ends within some seconds."""
    for _ in range(100):
        try:
            os.kill(process, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.1)
    return False


def test_the_same_processes_do_all_tasks_and_end_when_closed(monkeypatch):
    monkeypatch.setenv("POLARS_MAX_THREADS", "7")
    with closing(Processes(2)) as workers:
        first = set(workers.run(TASKS))
        threads = set(workers.run([(os.getenv, ("POLARS_MAX_THREADS",))]))
        second = set(workers.run(TASKS))
    assert os.getpid() not in first and len(first | second) <= 2
    assert threads == {"1"} and os.environ["POLARS_MAX_THREADS"] == "7"
    assert all(map(ended, first | second))


@pytest.mark.skipif(os.name == "nt", reason="needs SIGKILL")
def test_processes_that_die_between_two_stages_are_replaced():
    with closing(Processes(2)) as workers:
        before = set(workers.run(TASKS))
        for process in before:
            os.kill(process, signal.SIGKILL)
        assert all(map(ended, before))
        after = list(workers.run(TASKS))
    assert len(after) == len(TASKS) and not set(after) & before


@pytest.mark.skipif(os.name == "nt", reason="needs SIGKILL")
def test_processes_that_die_again_and_again_stop_the_run():
    with closing(Processes(1)) as workers, pytest.raises(Stopped, match="end again and again"):
        list(workers.run([(os.abort, ())]))
