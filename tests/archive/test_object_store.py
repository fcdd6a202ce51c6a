"""An archive in a bucket of an object store: whole objects alone, the manifest last, and it goes on after a kill."""

from __future__ import annotations

import hashlib
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import polars as pl
import pytest
from polars.testing import assert_frame_equal
from test_archive import SAME, flights, hashes, in_files, refused, track
from typer.testing import CliRunner

from jink.archive import run
from jink.archive.run import How, track_archive
from jink.archive.store import Store
from jink.cli.main import app
from jink.io.loading import Reading
from jink.tracking.prepare import Settings


@pytest.fixture
def hours(tmp_path):
    return in_files(tmp_path, flights())


@pytest.fixture(scope="module")
def bucket() -> Iterator[Any]:
    """An empty bucket of a server of this machine that speaks S3."""
    why = "pip install 'moto[server]': 40 packages, too many for every run; a store in memory is tested anyway"
    server = pytest.importorskip("moto.server", reason=why).ThreadedMotoServer(ip_address="127.0.0.1", port=0)
    boto3 = pytest.importorskip("boto3", reason=why)
    server.start()
    host, port = server.get_host_and_port()
    with pytest.MonkeyPatch.context() as patch:
        for name, value in {
            "AWS_ENDPOINT_URL": f"http://{host}:{port}",
            "AWS_ACCESS_KEY_ID": "test",
            "AWS_SECRET_ACCESS_KEY": "test",
            "AWS_DEFAULT_REGION": "us-east-1",
            "AWS_EC2_METADATA_DISABLED": "true",
        }.items():
            patch.setenv(name, value)
        boto3.client("s3").create_bucket(Bucket="archive")
        yield boto3.resource("s3").Bucket("archive")
    server.stop()


def objects(bucket: Any) -> dict[str, str]:
    """The hash of each object."""
    return {each.key: hashlib.sha256(each.get()["Body"].read()).hexdigest() for each in bucket.objects.all()}


def of_tracks(found: dict[str, str], under: str) -> dict[str, str]:
    return {name.removeprefix(under): value for name, value in found.items() if name.startswith(f"{under}bucket=")}


def files_of(folder: Path) -> set[str]:
    """All files of a folder and what is beside it."""
    inside = {path.relative_to(folder.parent).as_posix() for path in folder.rglob("*") if path.is_file()}
    return inside | {f"{folder.name}.rejected.parquet"}


def test_objects_are_the_files_of_a_folder_and_of_the_same_bytes(tmp_path, hours, bucket):
    bucket.objects.all().delete()
    summary = track(*hours, "-o", "s3://archive/day/tracks/", *SAME)
    assert summary["written"] == ["s3://archive/day/tracks/", "s3://archive/day/tracks.rejected.parquet"]
    track(*hours, "-o", f"{tmp_path}/tracks/", *SAME)
    found = objects(bucket)
    assert of_tracks(found, "day/tracks/") == hashes(tmp_path / "tracks")
    assert {name.removeprefix("day/") for name in found} == files_of(tmp_path / "tracks")
    assert track(*hours, "-o", "s3://archive/day/tracks", *SAME) == summary


def test_killed_at_any_moment_it_goes_on_with_the_same_bytes(tmp_path, hours, bucket):
    """Whatever is there after kill -9 is whole, and the manifest is there only when all is."""
    bucket.objects.all().delete()
    track(*hours, "-o", f"{tmp_path}/tracks/", *SAME)
    command = [sys.executable, "-m", "jink", "track", *map(str, hours), "-o", "s3://archive/tracks/", *SAME]
    for after in (".jink/map/00001.json", ".jink/reduce/003.json"):
        process = subprocess.Popen([*command, "--quiet"])
        while f"tracks/{after}" not in {each.key for each in bucket.objects.all()}:
            assert process.poll() is None
            time.sleep(0.02)
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
        found = objects(bucket)
        assert "tracks/.jink/manifest.json" not in found
        assert of_tracks(found, "tracks/").items() <= hashes(tmp_path / "tracks").items()
    track(*hours, "-o", "s3://archive/tracks/", *SAME)
    found = objects(bucket)
    assert of_tracks(found, "tracks/") == hashes(tmp_path / "tracks")
    assert set(found) == files_of(tmp_path / "tracks")


def test_a_bucket_that_is_not_there_is_said(hours, bucket):
    done = CliRunner().invoke(app, ["track", *map(str, hours), "-o", "s3://nothing/tracks/", *SAME, "--quiet"])
    assert done.exit_code == 1 and "in bucket 'nothing'" in done.stderr and done.stderr.count("\n") == 1, done.output


def test_a_store_as_a_whole_is_refused(hours):
    assert "is a whole store; give a folder in it" in refused(*hours, "-o", "s3://archive/", *SAME)


def test_options_of_a_url_stand_at_its_end():
    store = Store("s3://archive/day/tracks/?scheme=http&endpoint_override=127.0.0.1:9")
    assert store.where == "s3://archive/day/tracks?scheme=http&endpoint_override=127.0.0.1:9"
    beside, name = store.beside()
    assert (beside.where, name) == ("s3://archive/day?scheme=http&endpoint_override=127.0.0.1:9", "tracks")
    assert store.named(".x") == "s3://archive/day/tracks.x?scheme=http&endpoint_override=127.0.0.1:9"
    assert Store("/tracks/").beside() == (Store("/"), "tracks") and Store("/").where == "/"


def test_a_store_in_memory_has_complete_objects_and_the_manifest_last(tmp_path, hours):
    fsspec = pytest.importorskip("fsspec")
    store = fsspec.filesystem("memory")
    where = f"memory://archive{threading.get_ident()}/tracks"
    once = run.reduce_bucket
    seen = []

    def reduce_bucket(*arguments):
        assert not store.glob(f"{where}/.jink/manifest.json")
        if len(seen) == 3:
            raise KeyboardInterrupt
        seen.append(arguments[2])
        return once(*arguments)

    def made():
        return track_archive(hours, where, Reading(), Settings(), How(10**9, 1), lambda event: None)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(run, "reduce_bucket", reduce_bucket)
        with pytest.raises(KeyboardInterrupt):
            made()
    summary, written = made()
    assert written == [where, f"{where}.rejected.parquet"]
    track(*hours, "-o", f"{tmp_path}/whole/", *SAME)
    root = where.removeprefix("memory:/")
    for name, wanted in hashes(tmp_path / "whole").items():
        assert hashlib.sha256(store.cat_file(f"{root}/{name}")).hexdigest() == wanted
    with store.open(f"{root}.rejected.parquet") as handle:
        rejected = pl.read_parquet(handle.read())
    assert_frame_equal(rejected, pl.read_parquet(Path(f"{tmp_path}/whole.rejected.parquet")))
    assert summary["accepted"] + rejected.height == summary["rows"]
    store.rm(where.removeprefix("memory:/").rpartition("/")[0], recursive=True)
