"""An archive made by workers of dask, of which some die; and one in an object store."""

from __future__ import annotations

import os
import signal
import warnings

import pytest
from test_archive import SAME, all_rows, flights, hashes, in_files, track

from jink.archive import job, run
from jink.archive.errors import Stopped
from jink.archive.run import How, track_archive
from jink.io.loading import Reading
from jink.tracking.prepare import Settings

GB = 10**9


@pytest.fixture
def hours(tmp_path):
    return in_files(tmp_path, flights())


@pytest.fixture
def client():
    distributed = pytest.importorskip("distributed")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        cluster = distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None, processes=True
        )
        with cluster, distributed.Client(cluster) as client:
            yield client


@pytest.mark.filterwarnings("ignore")
def test_workers_that_die_in_either_stage_change_no_byte(tmp_path, hours, client):
    track(*hours, "-o", f"{tmp_path}/whole/", *SAME)
    died = []

    def say(event):
        """One worker is killed while files are divided, and one while buckets are tracked."""
        if event["event"] not in died and event["event"] in ("map", "reduce"):
            died.append(event["event"])
            worker = next(iter(client.run(os.getpid).values()))
            os.kill(worker, signal.SIGKILL)

    summary, _ = track_archive(hours, f"{tmp_path}/tracks", Reading(), Settings(), How(GB, 2, cluster=client), say)
    assert died == ["map", "reduce"]
    assert hashes(tmp_path / "tracks") == hashes(tmp_path / "whole")
    assert summary["accepted"] == all_rows(tmp_path / "whole").height


@pytest.mark.filterwarnings("ignore")
def test_a_worker_of_another_version_is_refused(tmp_path, hours, client, monkeypatch):
    real = job.versions()
    monkeypatch.setattr(run, "versions", lambda: real | {"jink": "9.9.9"})
    with pytest.raises(Stopped, match=rf"a worker has jink {real['jink']}, but the archive is made with 9\.9\.9"):
        track_archive(
            hours, f"{tmp_path}/tracks", Reading(), Settings(), How(GB, 2, cluster=client), lambda event: None
        )


def test_no_scheduler_is_said(tmp_path, hours):
    pytest.importorskip("distributed")
    with pytest.raises(Stopped, match="no scheduler answers"):
        How(GB, 2, cluster="tcp://127.0.0.1:9").workers()
