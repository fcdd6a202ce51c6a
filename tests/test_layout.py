"""The rules of the house: which room may import which, read from the source."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

SOURCE = Path(__file__).parents[1] / "src" / "jink"
# from the ground up; rooms on one floor do not import each other, except the loose files on the first
FLOORS = (
    ("_engine", "_processor", "frozen", "times", "checks", "frame_of", "estimate", "io"),
    ("models",),
    ("metrics", "stepwise"),
    ("filters",),
    ("association", "catalogue"),
    ("tracking", "interop"),
    ("archive",),
    ("scenarios",),
    ("compare",),
    ("fit",),
    ("learn",),
    ("papers",),
    ("report",),
    ("service",),
    ("cli",),
)
FLOOR = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}
FACE = ("__init__", "__main__")


def imports(path: Path) -> list[tuple[str, str]]:
    """(room, module) of jink that a file imports, and other packages as ("", name)."""
    package = path.relative_to(SOURCE.parent).parent.parts
    found = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(package[: len(package) - node.level + 1]) if node.level else ""
            stem = ".".join(filter(None, (base, node.module)))
            inner = [f"{stem}.{alias.name}" for alias in node.names]
            names = [name if name in MODULES else stem for name in inner]
        else:
            continue
        found += [(n.split(".")[1], n) if n.startswith("jink.") else ("", n) for n in names]
    return found


def _name(path: Path) -> str:
    return ".".join(path.relative_to(SOURCE.parent).with_suffix("").parts).removesuffix(".__init__")


MODULES = {_name(p): p for p in sorted(SOURCE.rglob("*.py"))}
FILES = {p: p.relative_to(SOURCE).parts[0].removesuffix(".py") for p in MODULES.values()}


def test_imports_point_down():
    wrong = [
        f"{path.relative_to(SOURCE)} imports {module}"
        for path, room in FILES.items()
        if room not in FACE
        for to, module in imports(path)
        if to and to != room and FLOOR.get(to, 99) >= FLOOR[room] and not FLOOR.get(to) == FLOOR[room] == 0
    ]
    assert not wrong, "\n".join(wrong)


def test_files_import_each_other_in_no_circle():
    waiting = {n: {m for _, m in imports(p) if m in MODULES and m not in (n, "jink")} for n, p in MODULES.items()}
    while ready := {name for name, needs in waiting.items() if not needs & waiting.keys()}:
        waiting = {name: needs for name, needs in waiting.items() if name not in ready}
    assert not waiting, "\n".join(f"{n} waits for {sorted(needs)}" for n, needs in waiting.items())


def test_only_the_command_line_imports_typer_and_commands_are_apart():
    commands = {p.stem for p in (SOURCE / "cli").glob("*.py")} - {"main", "request", "exit_status", "__init__"}
    for path, room in FILES.items():
        for _, module in imports(path):
            assert room == "cli" or module.split(".")[0] != "typer", path
            if room == "cli" and path.stem in commands:
                assert module.removeprefix("jink.cli.") not in commands, (path, module)


def test_import_jink_imports_numpy_alone():
    code = "import sys; before = set(sys.modules); import jink; "
    "print(*sorted({m.split('.')[0] for m in set(sys.modules) - before}))"
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert {m for m in shown if m not in sys.stdlib_module_names} <= {"jink", "numpy"}


def test_tests_have_names_of_their_own():
    """pytest takes two files of one name for one module."""
    names = [path.name for path in Path(__file__).parent.rglob("test_*.py")]
    assert len(names) == len(set(names))
