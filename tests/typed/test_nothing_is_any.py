"""No public function, method or field takes or gives `Any`; the type checker can then say what is wrong in a script."""

import ast
import importlib
import inspect
import re
import textwrap
import typing
from collections.abc import Iterator

import pytest

import jink

ROOMS = ("compare", "fit", "metrics", "scenarios")
ANY = re.compile(r"(?<!NDArray\[)\bAny\b")  # an array of any kind of number is an array
# what runs a bank: the native engine, or that for models of your own
ALLOWED = {"Bank.engine"}


def subjects() -> dict[str, object]:
    """What `jink` and its rooms offer, by name."""
    found = {name: getattr(jink, name) for name in jink.__all__}
    for room in ROOMS:
        module = importlib.import_module(f"jink.{room}")
        found |= {f"{room}.{name}": getattr(module, name) for name in module.__all__}
    return {name: thing for name, thing in found.items() if inspect.isclass(thing) or inspect.isfunction(thing)}


def told(function: ast.FunctionDef) -> Iterator[str]:
    """The annotations of a function, "missing" where there is none."""
    a = function.args
    for given in [*a.posonlyargs, *a.args, *a.kwonlyargs, a.vararg, a.kwarg]:
        if given is not None and given.arg not in ("self", "cls"):
            yield ast.unparse(given.annotation) if given.annotation else "missing"
    yield ast.unparse(function.returns) if function.returns else "missing"


def parsed(thing: object) -> ast.stmt:
    return ast.parse(textwrap.dedent(inspect.getsource(thing))).body[0]  # type: ignore[arg-type]


def loose(thing: object) -> list[str]:
    """The public parts of a class or function that are `Any`."""
    if inspect.isfunction(thing):
        seen = parsed(thing)
        assert isinstance(seen, ast.FunctionDef)
        open_ = not typing.get_overloads(thing) and any(map(is_loose, told(seen)))
        return [thing.__name__] if open_ else []
    out: list[str] = []
    for each in typing.cast(type, thing).__mro__:
        if each.__module__.startswith("jink"):
            body = typing.cast(ast.ClassDef, parsed(each)).body
            out += [f"{each.__name__}.{name}" for name in loose_members(body)]
    return [name for name in out if name not in ALLOWED]


def is_loose(annotation: str) -> bool:
    return annotation == "missing" or ANY.search(annotation) is not None


def loose_members(body: list[ast.stmt]) -> Iterator[str]:
    overloaded = {
        part.name
        for part in body
        if isinstance(part, ast.FunctionDef) and any("overload" in ast.unparse(d) for d in part.decorator_list)
    }
    for part in body:
        if isinstance(part, ast.FunctionDef) and part.name not in overloaded:
            public = not part.name.startswith("_") or part.name in ("__init__", "__new__")
            if public and any(map(is_loose, told(part))):
                yield part.name
        if isinstance(part, ast.AnnAssign) and is_loose(ast.unparse(part.annotation)):
            name = ast.unparse(part.target)
            if not name.startswith("_"):
                yield name


@pytest.mark.parametrize("name", subjects())
def test_public_types_say_what_they_are(name: str) -> None:
    assert loose(subjects()[name]) == []


def test_a_loose_signature_is_found() -> None:
    body = ast.parse(
        "class A:\n x: Any\n y: int\n def f(self, a: dict[str, Any]) -> int: ...\n def g(self, b): ..."
    ).body[0]
    assert list(loose_members(typing.cast(ast.ClassDef, body).body)) == ["x", "f", "g"]
