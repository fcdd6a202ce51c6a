"""Tiles of a map server under the tracks: asked for where they belong, said where they cannot be had."""

from __future__ import annotations

import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import numpy as np
import polars as pl
import pytest
from typer.testing import CliRunner

from jink.cli.main import app
from jink.io.errors import InputError
from jink.report import write_report
from jink.report.picture import mask
from jink.report.tiles import Tiles


@pytest.fixture
def server():
    """(address of the tiles, paths asked for) of a server on loopback whose tiles are white squares."""
    import base64

    picture = base64.b64decode(mask(np.full((256, 256), 255, dtype=np.uint8)).partition(",")[2])
    asked: list[str] = []

    class Answer(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            asked.append(self.path)
            self.send_response(200)
            self.send_header("Content-Type", "image/png")
            self.send_header("Access-Control-Allow-Origin", "*")
            self.end_headers()
            self.wfile.write(picture)

        def log_message(self, *words: object) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Answer) as running:
        threading.Thread(target=running.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{running.server_port}/{{z}}/{{x}}/{{y}}.png", asked
        running.shutdown()


def near_munich() -> pl.DataFrame:
    k = np.arange(60)
    place = {"latitude": 48.0 + 0.005 * k, "longitude": 11.3 + 0.004 * k}
    return pl.DataFrame({"target": "a", "time": k.astype(float), **place})


def columns_and_rows(asked: list[str]) -> set[tuple[int, int, int]]:
    return {tuple(int(part) for part in path.removesuffix(".png").split("/")[1:]) for path in asked}  # type: ignore[misc]


def test_the_page_asks_for_the_tiles_of_the_place(open_page, tmp_path, server):
    url, asked = server
    write_report(near_munich(), tmp_path / "page.html", summary={}, tiles=url)
    opened = open_page(tmp_path / "page.html")
    opened.page.wait_for_timeout(600)
    assert not opened.complaints
    tiles = columns_and_rows(asked)
    z = min(tiles)[0]
    assert max(tiles)[0] == z and 8 <= z <= 13
    # the usual formula: 48.15° N, 11.42° E is in the middle
    column = int((11.42 + 180.0) / 360.0 * 2**z)
    row = int((1.0 - np.arcsinh(np.tan(np.radians(48.15))) / np.pi) / 2.0 * 2**z)
    assert (z, column, row) in tiles and len(tiles) < 100


def test_a_picture_of_the_view_can_still_be_saved(open_page, tmp_path, server):
    write_report(near_munich(), tmp_path / "page.html", summary={}, tiles=server[0])
    opened = open_page(tmp_path / "page.html")
    opened.page.wait_for_timeout(400)
    with opened.page.expect_download() as saved:
        opened.page.click("#plan-png")
    assert saved.value.path().read_bytes().startswith(b"\x89PNG")


def test_without_an_address_nothing_is_asked_for(open_page, tmp_path):
    write_report(near_munich(), tmp_path / "page.html", summary={})
    opened = open_page(tmp_path / "page.html")
    assert [r for r in opened.requests if r.startswith("http")] == []
    assert 'img-src data:"' in (tmp_path / "page.html").read_text()


@pytest.mark.parametrize(
    "url",
    [
        "tile.example.org/{z}/{x}/{y}.png",
        "ftp://tile.example.org/{z}/{x}/{y}.png",
        "https://tile.example.org/{z}/{x}.png",
        "https://{s}.example.org/{z}/{x}/{y}.png",
        "https://a.org; script-src *{z}{x}{y}",
        "https://a.org/{z}/{x}/{y}.png?'><script>",
        "https://a.org/{z}/{x}/{y}/{y}",
        "",
    ],
)
def test_other_addresses_are_refused(url):
    with pytest.raises(InputError, match="tiles is"):
        Tiles(url)


def test_the_policy_of_the_page_names_the_server_alone(tmp_path):
    write_report(near_munich(), tmp_path / "page.html", summary={}, tiles="https://maps.example.org:8443/t/{z}/{x}/{y}")
    assert 'img-src data: https://maps.example.org:8443"' in (tmp_path / "page.html").read_text()


def test_the_command_line_takes_them_with_a_page_alone(tmp_path):
    near_munich().write_parquet(tmp_path / "t.parquet")
    url = "https://tile.example.org/{z}/{x}/{y}.png"
    command = ["track", f"{tmp_path}/t.parquet", "-o", f"{tmp_path}/o.parquet", "--quiet", "--tiles"]
    done = CliRunner().invoke(app, [*command, url])
    assert done.exit_code == 2 and "--report" in done.stderr
    done = CliRunner().invoke(app, [*command, "nowhere", "--report", f"{tmp_path}/o.html"])
    assert done.exit_code == 2 and "tiles is 'nowhere'" in done.stderr and not (tmp_path / "o.parquet").exists()
    done = CliRunner().invoke(app, [*command, url, "--report", f"{tmp_path}/o.html"])
    assert done.exit_code == 0, done.output
    assert "come from https://tile.example.org" in (tmp_path / "o.html").read_text()
    done = CliRunner().invoke(
        app, ["report", f"{tmp_path}/o.parquet", "--tiles", url, "-o", f"{tmp_path}/r.html", "-q"]
    )
    assert done.exit_code == 0 and "img-src data: https://tile.example.org" in (tmp_path / "r.html").read_text()
