"""A docstring is a sentence that somebody understands who has not read the code: it has a subject."""

import ast

import pytest

from tests.project import ROOT

NO_SUBJECT = ("Of", "That", "Whose", "Whom", "As")
"""First words after which a noun is missing, as in "Of all envs together" for "The space of all envs together"."""


def docstrings(source):
    """Every docstring of a module, those below constants and fields too: its line and its text."""
    for node in ast.walk(ast.parse(source)):
        body = getattr(node, "body", None)
        for it in body if isinstance(body, list) else []:
            if isinstance(it, ast.Expr) and isinstance(it.value, ast.Constant) and isinstance(it.value.value, str):
                yield it.lineno, it.value.value


def without_subject(source):
    """The lines of docstrings that begin without a subject."""
    return [line for line, text in docstrings(source) if text.split(maxsplit=1)[0].rstrip(",:;.") in NO_SUBJECT]


@pytest.mark.parametrize("folder", ["harness", "plugins", "robots"])
def test_every_docstring_has_a_subject(folder):
    """Also below constants, fields and private functions."""
    paths = sorted((ROOT / folder).rglob("*.py"))
    assert not [f"{path.relative_to(ROOT)}:{line}" for path in paths for line in without_subject(path.read_text())]


def methods(source):
    """Every public method of a public class: its line, its name, whether it has a docstring."""
    for node in ast.walk(ast.parse(source)):
        body = node.body if isinstance(node, ast.ClassDef) and not node.name.startswith("_") else []
        for method in body:
            if isinstance(method, ast.FunctionDef) and not method.name.startswith("_"):
                yield method.lineno, method.name, ast.get_docstring(method) is not None


def test_a_method_without_a_docstring_fills_one_that_has_one():
    """The protocol or the base class says what it does, once; so a method of a class's own has to say it itself."""
    paths = [path for root in ("harness", "plugins", "robots") for path in sorted((ROOT / root).rglob("*.py"))]
    found = [
        (f"{path.relative_to(ROOT)}:{line}", name, told)
        for path in paths
        for line, name, told in methods(path.read_text())
    ]
    described = {name for _, name, told in found if told}
    assert not [f"{place} {name}" for place, name, told in found if not told and name not in described]


def test_methods_are_told_from_functions():
    """A function outside any class is ruff's; a private method needs no docstring."""
    source = (
        'def f(): ...\nclass A:\n    def b(self): ...\n    def _c(self): ...\n    def d(self):\n        """Say."""\n'
    )
    assert list(methods(source)) == [(3, "b", False), (5, "d", True)]


@pytest.mark.parametrize(
    ("source", "lines"),
    [
        ('SIZE = 3\n"""Of a file."""\n', [2]),
        ('def f():\n    """That are tried."""\n', [2]),
        ('def f():\n    """The rows that are tried."""\n', []),
        ('"""Often it is so."""\n', []),
    ],
)
def test_the_check_finds_what_it_has_to(source, lines):
    """Below a constant, in a function; a word that only begins like one of these is none."""
    assert without_subject(source) == lines
