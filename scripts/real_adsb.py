"""What dump1090-mutability (a Debian package) writes of messages that aircraft sent: SBS-1 and aircraft.json.

The messages are those of the tutorial in traffic's source package, 40 seconds of them. They go to the decoder's port
at the pace at which they came, because it stamps what it writes with its own clock.
"""

import gzip
import json
import os
import socket
import subprocess
import tempfile
import threading
import time
from collections.abc import Sequence
from pathlib import Path

SECONDS = 40.0
HOST = "127.0.0.1"


def frames(tutorial: Path) -> list[tuple[float, str]]:
    """Seconds since the first, and messages in hexadecimal: the 40 seconds that have the most positions."""
    with gzip.open(tutorial, "rt", encoding="utf-8") as lines:
        rows = [json.loads(line) for line in lines]
    of_positions = [row["timestamp"] for row in rows if row.get("bds") == "05"]
    counts = [sum(start <= t < start + SECONDS for t in of_positions) for start in of_positions[::50]]
    begin = of_positions[::50][counts.index(max(counts))]
    return [(t - begin, row["frame"]) for row in rows if begin <= (t := row["timestamp"]) < begin + SECONDS]


def decoded(program: Path, libraries: Path, messages: Sequence[tuple[float, str]], folder: Path) -> tuple[Path, Path]:
    """Files `dump1090.sbs` and `dump1090.jsonl` (a snapshot per line) in the folder, written once."""
    sbs, snapshots = folder / "dump1090.sbs", folder / "dump1090.jsonl"
    if sbs.exists() and snapshots.exists():
        return sbs, snapshots
    with tempfile.TemporaryDirectory() as shared:
        inlet, outlet = (free_port() for _ in range(2))
        command = [str(program), "--net-only", "--quiet", "--net-bind-address", HOST, "--write-json", shared]
        closed = ["--net-ro-port", "0", "--net-bi-port", "0", "--net-bo-port", "0"]
        ports = ["--net-ri-port", str(inlet), "--net-sbs-port", str(outlet), *closed]
        libraries_too = {**os.environ, "LD_LIBRARY_PATH": str(libraries)}
        with subprocess.Popen([*command, *ports], env=libraries_too) as decoder:
            try:
                received, shots = play(inlet, outlet, messages, Path(shared) / "aircraft.json")
            finally:
                decoder.terminate()
    sbs.write_bytes(received)
    snapshots.write_text("".join(json.dumps(json.loads(shot)) + "\n" for shot in shots), encoding="utf-8")
    return sbs, snapshots


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind((HOST, 0))
        return int(probe.getsockname()[1])


def play(inlet: int, outlet: int, messages: Sequence[tuple[float, str]], shot: Path) -> tuple[bytes, list[str]]:
    """What came out at the outlet, and each state of the file of all aircraft, while the messages went in."""
    received, shots = bytearray(), []
    with connected(inlet) as sender, connected(outlet) as listener:
        listener.settimeout(0.2)
        over = threading.Event()

        def listen() -> None:
            while not over.is_set():
                try:
                    received.extend(listener.recv(1 << 16))
                except TimeoutError:
                    continue

        thread = threading.Thread(target=listen)
        thread.start()
        begin = time.monotonic()
        for due, frame in messages:
            time.sleep(max(0.0, begin + due - time.monotonic()))
            sender.sendall(f"*{frame};\n".encode())
            text = shot.read_text(encoding="utf-8") if shot.exists() else ""
            if text and text not in shots[-1:]:
                shots.append(text)
        time.sleep(1.0)
        over.set()
        thread.join()
    return bytes(received), shots


def connected(port: int) -> socket.socket:
    """A connection to the decoder, which may need a moment to begin."""
    for _ in range(50):
        try:
            return socket.create_connection((HOST, port), timeout=1.0)
        except OSError:
            time.sleep(0.1)
    raise OSError(f"dump1090 does not listen on port {port}")
