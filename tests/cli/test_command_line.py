"""The command line: commands made of requests, help, names from registries, completion, `python -m jink`."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from dataclasses import fields
from typing import get_type_hints

import pytest
from typer.testing import CliRunner

from jink.cli import track
from jink.cli.main import COMMANDS, app_of, run_of
from jink.cli.plain_values import PlainValues
from jink.cli.request import REGISTRIES, completed_from, names_of
from jink.cli.simulate import SimulateRequest
from jink.models.provenance import VERSION


def jink(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "jink", *arguments],
        env={**os.environ, "COLUMNS": "100", "NO_COLOR": "1", **environment},
        capture_output=True,
        text=True,
        check=False,
    )


def requests():
    return {name: next(k for n, k in get_type_hints(run_of(name)).items() if n != "return") for name in COMMANDS}


def test_python_m_jink_is_jink():
    assert jink("--version").stdout == f"jink {VERSION}\n"
    assert "Usage: jink [OPTIONS] COMMAND" in jink("--help").stdout


@pytest.mark.parametrize("name", COMMANDS)
def test_every_field_of_a_request_is_an_option_or_argument_with_help(name):
    request = requests()[name]
    hints = get_type_hints(request, include_extras=True)
    for field in fields(request):
        (option,) = hints[field.name].__metadata__
        assert option.help and option.help.endswith((".", ".)")), field.name
    shown = jink(name, "--help").stdout
    assert " ".join(request.__doc__.split("\n\n")[0].split()) in re.sub(r"\s+", " ", shown)
    assert "{" not in shown.split("\n\n", 1)[1].replace("{INPUT}", "").partition("Arguments")[2]


@pytest.mark.parametrize("columns", ["80", "100"])
@pytest.mark.parametrize("name", ["", *COMMANDS])
def test_help_fits_and_is_not_cut(name, columns):
    shown = jink(*filter(None, [name, "--help"]), COLUMNS=columns).stdout
    assert max(map(len, shown.splitlines())) <= int(columns)
    assert "…" not in shown.replace("true_x,vx=…", "").replace("M/S²,…", "")


def test_sentences_of_help_are_short():
    """A sentence has under 25 words."""
    for name, request in requests().items():
        hints = get_type_hints(request, include_extras=True)
        texts = [request.__doc__ or "", *(hints[f.name].__metadata__[0].help for f in fields(request))]
        for sentence in (s for text in texts for s in re.split(r"[.;:?]\s", text)):
            assert len(sentence.split()) < 25, (name, sentence)


@pytest.mark.parametrize("registry", REGISTRIES)
def test_names_come_from_the_registries(registry):
    assert len(names_of(registry)) > 2
    assert completed_from(registry)("x")[:1] == names_of(registry)[:1]
    assert completed_from(registry)("a,b,c")[0] == f"a,b,{names_of(registry)[0]}"


def test_help_lists_what_a_registry_holds(monkeypatch):
    from jink.catalogue import targets

    monkeypatch.setitem(targets.KINDS, "balloon", targets.KINDS["drone"])
    shown = CliRunner(env={"COLUMNS": "200"}).invoke(app_of(), ["track", "--help"]).stdout
    assert all(kind in shown for kind in targets.KINDS) and "balloon" in shown


def test_the_shell_completes():
    script = jink("--show-completion", "bash", _TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION="1").stdout
    assert "_JINK_COMPLETE" in script
    for words, expected in (("jink comp", "compare"), ("jink track x.csv --kind ves", "vessel")):
        asked = {"COMP_WORDS": words, "COMP_CWORD": str(len(words.split()) - 1), "_JINK_COMPLETE": "complete_bash"}
        assert jink(**asked).stdout.split() == [expected]


@pytest.mark.parametrize("command", ["track", "simulate", "compare", "fit", "learn"])
def test_an_unknown_kind_is_answered_with_the_nearest(command, tmp_path):
    path = tmp_path / "s.csv"
    path.write_text("t,x,y\n" + "".join(f"{k},{k},{k}\n" for k in range(20)))
    asked = {
        "track": [str(path), "--json"],
        "simulate": ["lee-2003", "-o", str(tmp_path / "o.csv")],
        "compare": [str(path)],
        "fit": [str(path)],
        "learn": ["nn-kf", str(path)],
    }
    done = CliRunner().invoke(app_of(), [command, *asked[command], "--kind", "vesel"])
    assert done.exit_code == 2 and "did you mean vessel" in done.stderr


def test_sensor_options_are_those_of_a_scenario():
    request = SimulateRequest(name="lee-2003", output="o.csv", sensor="radar-4s", detection=0.9)
    assert request.sensor_options == {"sensor": "radar-4s", "detection": 0.9}
    assert request.seeing.sensor == "radar-4s" and request.seeing.interval is None


@pytest.mark.parametrize(
    "given",
    [
        ["a.csv"],
        ["a.csv", "b.csv", "-o", "o.parquet", "--keep", "a,b", "--keep", "c", "--azimuth-from", "grid", "-s"],
        ["-", "--gap", "4", "--min-points", "7", "--time-unit", "ms", "--kind", "vessel"],
    ],
)
def test_plain_values_are_those_that_typer_makes(given, monkeypatch):
    requests = []

    def kept(request: track.TrackRequest) -> int:
        requests.append(request)
        return 0

    monkeypatch.setattr(track, "run_track", kept)
    assert CliRunner().invoke(app_of("track"), ["track", *given]).exit_code == 0
    monkeypatch.setattr(PlainValues, "parse_args", lambda self, *given: super(PlainValues, self).parse_args(*given))
    assert CliRunner().invoke(app_of("track"), ["track", *given]).exit_code == 0
    one, other = requests
    assert one == other and list(map(type, vars(one).values())) == list(map(type, vars(other).values()))


def test_a_command_imports_itself_alone(tmp_path):
    code = (
        "import sys\nfrom jink.cli.main import main\ntry:\n    main()\nexcept SystemExit:\n"
        "    print(*(m for m in sys.modules if m.startswith(('jink.cli.', 'pydantic'))))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, "track", "no.csv", "-q", "-o", f"{tmp_path}/o.csv"], capture_output=True, text=True
    )
    assert "no such file: no.csv" in done.stderr
    modules = done.stdout.split()
    assert "jink.cli.track" in modules
    assert not [m for m in modules if m.removeprefix("jink.cli.") in {*COMMANDS} - {"track"} or "pydantic" in m]


def test_help_needs_little_more_than_numpy():
    """Nothing of scenarios, filters' catalogue, learning or tables is imported for `jink --help`."""
    code = "import sys, jink.cli.main; print(*sorted(m for m in sys.modules if m.startswith('jink.')))"
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    rooms = {module.split(".")[1] for module in shown}
    assert not rooms & {"scenarios", "catalogue", "learn", "fit", "compare", "papers", "report", "tracking"}


@pytest.mark.parametrize("own", [None, "mimalloc"])
def test_arrow_takes_memory_from_the_c_library_unless_it_is_told_otherwise(own):
    code = (
        "from jink.cli.main import main\ntry:\n    main()\nexcept SystemExit:\n"
        "    import pyarrow\n    print(pyarrow.default_memory_pool().backend_name)"
    )
    environment = {name: value for name, value in os.environ.items() if name != "ARROW_DEFAULT_MEMORY_POOL"}
    if own:
        environment["ARROW_DEFAULT_MEMORY_POOL"] = own
    done = subprocess.run(
        [sys.executable, "-c", code, "--version"], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout.split()[-1] == (own or "system")
