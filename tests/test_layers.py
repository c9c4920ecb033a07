"""What imports what inside `harness`: no module needs itself, neither when it is imported nor when it is called."""

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import harness

ROOT = Path(harness.__file__).parent


def _name_of(path):
    return ".".join(["harness", *path.relative_to(ROOT).with_suffix("").parts]).removesuffix(".__init__")


SOURCES = {_name_of(path): path.read_text() for path in sorted(ROOT.rglob("*.py"))}
FOR_CHECKERS = "TYPE_CHECKING"


def _looked_up(tree):
    """The imports by which a face says what it looks up when somebody asks: `X as X`, for type checkers."""
    for node in ast.walk(tree):
        if isinstance(node, ast.If) and ast.unparse(node.test) == FOR_CHECKERS:
            found = [it for it in node.body if isinstance(it, ast.ImportFrom)]
            yield from (it for it in found if all(alias.name == alias.asname for alias in it.names))


def _imports(tree, left_out):
    """Module and names of every import, at whatever depth, those for type checkers too."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.expr) or node in left_out:
            continue  # imports nothing
        if isinstance(node, ast.Import):
            yield from ((alias.name, []) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute here"
            yield node.module or "", [alias.name for alias in node.names]
        else:
            yield from _imports(node, left_out)


def import_graph(sources):
    """By module: the modules of `sources` that it imports anywhere; of a face's names the modules that they are from.

    What a face looks up when somebody asks is no import of its own.
    """
    trees = {module: ast.parse(source) for module, source in sources.items()}
    asked = {module: [*_looked_up(tree)] for module, tree in trees.items()}
    homes = {(face, it.name): node.module for face, nodes in asked.items() for node in nodes for it in node.names}
    graph = {module: set() for module in sources}
    for module, tree in trees.items():
        for imported, names in _imports(tree, asked[module]):
            for name in names or [""]:
                inner = f"{imported}.{name}"  # a module of a package, or a name in a module
                graph[module] |= {inner if inner in sources else imported, homes.get((imported, name), imported)}
        graph[module] &= set(sources)
    return graph


def circle(graph):
    """Modules that import one another, one after the next, the first once more at the end; empty if there are none."""
    try:
        tuple(TopologicalSorter(graph).static_order())
    except CycleError as error:
        return list(reversed(error.args[1]))
    return []


@pytest.fixture(scope="module")
def graph():
    """What each module of `harness` imports."""
    return import_graph(SOURCES)


def test_no_module_imports_itself_by_way_of_others(graph):
    """Imports in functions count, and those for type checkers: a circle that one of them opens is a circle."""
    assert circle(graph) == []


def test_graph_is_that_of_the_code(graph):
    """It has the imports of a module: those at its top, those when it runs, and those for type checkers."""
    assert {"harness.errors", "harness.results.load", "harness.eta.curve"} <= graph["harness.cli.report"]
    assert "harness.task" in graph["harness.algorithm"]


CIRCLES = {
    "at the top": ("from harness.b import f\n", "import harness.a\n"),
    "in a function": ("from harness import b\n", "def f():\n    from harness.a import g\n"),
    "in a method's branch": (
        "import harness.b\n",
        "class C:\n    def f(self):\n        if 1:\n            import harness.a\n",
    ),
    "for type checkers": (
        "import harness.b\n",
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import harness.a\n",
    ),
    "of one": ("import harness.a\n", ""),
    "by way of what a face looks up": (
        "from harness.b import f\n",
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from harness.a import f as f\n",
    ),
}


@pytest.mark.parametrize(("first", "second"), CIRCLES.values(), ids=CIRCLES)
def test_circle_is_found(first, second):
    """The mutants: whichever way two modules import one another."""
    found = circle(import_graph({"harness.a": first, "harness.b": second}))
    assert set(found) <= {"harness.a", "harness.b"}
    assert found
