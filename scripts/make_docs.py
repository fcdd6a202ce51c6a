"""Build the documentation as a site: gather the pages, write the reference, run mkdocs; prints the time that it takes.

Pages keep their places, so that links between README.md, docs/ and benchmarks/ lead where they lead in the repository.
Links to what is no page, such as source files, become text.
"""

from __future__ import annotations

import ast
import os
import re
import resource
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "build" / "site-source"
PAGES = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/*.md", "benchmarks/*.md", "examples/README.md")
IMAGES = ("docs/images/*.*", "docs/images/scenarios/*.svg", "benchmarks/*.png", "benchmarks/*.svg")
LINK = re.compile(r"(?<!!)\[([^\]]+)\]\((?!https?:|#|mailto:)([^)#\s]+)(#[^)\s]*)?\)")
MARK = re.compile(r"<!-- run: .*? -->\n")


def gather() -> None:
    """Copy pages and images."""
    shutil.rmtree(SOURCE, ignore_errors=True)
    pages = [page for pattern in PAGES for page in sorted(ROOT.glob(pattern))]
    images = [image for pattern in IMAGES for image in sorted(ROOT.glob(pattern))]
    known = {*pages, *images}
    for page in pages:
        to = SOURCE / page.relative_to(ROOT)
        to.parent.mkdir(parents=True, exist_ok=True)
        text = MARK.sub("", page.read_text(encoding="utf-8"))
        to.write_text(LINK.sub(lambda link, page=page: _kept(link, page, known), text), encoding="utf-8")
    for image in images:
        to = SOURCE / image.relative_to(ROOT)
        to.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(image, to)


def _kept(link: re.Match[str], page: Path, known: set[Path]) -> str:
    return link[0] if (page.parent / link[2]).resolve() in known else link[1]


def reference() -> str:
    """A page of all public names, in the order of the alphabet; read from the source, nothing is imported."""
    tree = ast.parse((ROOT / "src" / "jink" / "__init__.py").read_text(encoding="utf-8"))
    named = next(
        node.value
        for node in tree.body
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and node.targets[0].id == "_HOME"
    )
    homes: dict[str, str] = ast.literal_eval(named)
    names = [f"jink.{_module(home, name)}.{name}" for name, home in homes.items()]
    names += ["jink.compare.race.compare", "jink.compare.result.Race", "jink.fit.fitting.fit", "jink.filters.own.Steps"]
    names += [f"jink.interop.{path.stem}" for path in sorted((ROOT / "src/jink/interop").glob("[a-z]*.py"))]
    return "# Reference\n\n" + "\n\n".join(f"::: {name}" for name in sorted(names, key=str.lower)) + "\n"


def _module(home: str, name: str) -> str:
    """The module that has a public name: a package's is where its __init__ takes it from."""
    package = ROOT / "src" / "jink" / home.replace(".", "/") / "__init__.py"
    if not package.is_file():
        return home
    for node in ast.parse(package.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ImportFrom) and name in [alias.name for alias in node.names]:
            return f"{home}.{node.module}"
    raise LookupError(f"{package}: does not import {name}")


def main() -> int:
    """Build strictly: a link that leads nowhere is an error."""
    began = time.perf_counter()
    gather()
    (SOURCE / "reference.md").write_text(reference(), encoding="utf-8")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet"]
    done = subprocess.run(command, cwd=ROOT, env={**os.environ, "NO_MKDOCS_2_WARNING": "1"}, check=False)
    if done.returncode == 0:
        pages = list((ROOT / "build" / "site").rglob("*.html"))
        size = sum(page.stat().st_size for page in pages) / 1e6
        own, children = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
        cpu = own.ru_utime + own.ru_stime + children.ru_utime + children.ru_stime
        wall = time.perf_counter() - began
        print(f"build/site/README.html: {len(pages)} pages, {size:.1f} MB; {wall:.1f} s, {cpu:.1f} s of CPU")
    return done.returncode


if __name__ == "__main__":
    sys.exit(main())
