"""What can be measured of the source without running it."""

import ast
import re
from functools import cache
from graphlib import TopologicalSorter

from tests.project import ROOT

TOPS = {"harness": "harness", "plugins": "harness_plugins", "robots": "harness_robots"}
"""Our folders, and what the packages in them are called."""
FORK = re.compile(
    r"\b(NO_SIMULATOR|NO_ROBOT|BROUGHT|require_arm|RecordedResults|arm_world|is_environment|(is_|\.)in_environment)\b"
)
"""Names by which code asks whether it has an arm or another environment."""
WORLDS = re.compile(
    r"^(harness/record/cell\.py|harness/experiment/(arm_)?world\.py|harness/experiment/environments/|harness/authoring/"
    r"|plugins/audit/search/(place|arm_world|environment_world)\.py)"
)
"""Files of the two worlds, those of a search too, and the cell, which says where it trains: what they say of themselves
is no fork."""


def files_of(*tops):
    """The Python files of our folders, in order."""
    return sorted(path for top in tops for path in (ROOT / top).rglob("*.py"))


@cache
def text_of(path):
    """A file's content."""
    return path.read_text()


def module_of(path):
    """What a file is called when it is imported."""
    top, *inner = path.relative_to(ROOT).with_suffix("").parts
    return ".".join([TOPS[top], *inner]).removesuffix(".__init__")


def _imports(tree):
    """Imports at a module's top, without those in functions and those for type checkers."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.Import | ast.ImportFrom):
            yield node
        elif isinstance(node, ast.expr):
            continue  # imports nothing
        elif not (
            isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
            or (isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test))
        ):
            yield from _imports(node)


def _absolute(node, module, is_package):
    parts = module.split(".")
    base = parts[: len(parts) - node.level + is_package] if node.level else []
    return ".".join([*base, *filter(None, [node.module])])


def import_graph(sources):
    """By module: the others of `sources` that it imports.

    Args:
        sources: By module, its text and whether it is a package.
    """
    graph = {}
    for module, (text, is_package) in sources.items():
        imported = set()
        for node in _imports(ast.parse(text)):
            if isinstance(node, ast.Import):
                imported |= {alias.name for alias in node.names}
                continue
            origin = _absolute(node, module, is_package)
            inner = {f"{origin}.{alias.name}" for alias in node.names}  # modules of a package, or names in a module
            imported |= inner & set(sources) | ({origin} if inner - set(sources) else set())
        graph[module] = imported & set(sources) - {module}
    return graph


def floors(graph):
    """How many modules the longest chain of imports has, the first and the last included."""
    depth = {}
    for module in TopologicalSorter(graph).static_order():
        depth[module] = 1 + max((depth[imported] for imported in graph[module]), default=0)
    return max(depth.values(), default=0)


def forks():
    """File and line, wherever code outside the two worlds asks whether it has an arm or another environment."""
    return [
        (name, number)
        for path in files_of("harness", "plugins")
        if not WORLDS.match(name := path.relative_to(ROOT).as_posix())
        for number, line in enumerate(text_of(path).splitlines(), start=1)
        if FORK.search(line)
    ]


@cache
def measured():
    """Every figure, by its name in `bounds.toml`."""
    core, asked = files_of("harness"), forks()
    return {
        "import floors": floors(
            import_graph({module_of(path): (text_of(path), path.stem == "__init__") for path in core})
        ),
        "files of harness": len(core),
        "lines that ask for the kind of world": len(asked),
        "files that ask for the kind of world": len({name for name, _ in asked}),
    }
