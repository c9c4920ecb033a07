"""What can be measured of the source without running it."""

import ast
import io
import re
import tokenize
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).parents[2]
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


def files_of(*tops: str) -> list[Path]:
    """The Python files of our folders, in order."""
    return sorted(path for top in tops for path in (ROOT / top).rglob("*.py"))


@cache
def text_of(path: Path) -> str:
    """A file's content."""
    return path.read_text(encoding="utf-8")


@cache
def _tree(text: str) -> ast.Module:
    return ast.parse(text)


def lines_of(paths: Iterable[Path]) -> int:
    """All of them, blank ones too."""
    return sum(text_of(path).count("\n") for path in paths)


def module_of(path: Path) -> str:
    """What a file is called when it is imported."""
    top, *inner = path.relative_to(ROOT).with_suffix("").parts
    return ".".join([TOPS[top], *inner]).removesuffix(".__init__")


def _imports(tree: ast.AST, *, inside: bool) -> Iterator[ast.Import | ast.ImportFrom]:
    """Imports at a module's top; those in functions and those for type checkers too if they are asked for."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.Import | ast.ImportFrom):
            yield node
        elif isinstance(node, ast.expr):
            continue  # imports nothing
        elif inside or not (
            isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
            or (isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test))
        ):
            yield from _imports(node, inside=inside)


def _absolute(node: ast.ImportFrom, module: str, is_package: bool) -> str:
    parts = module.split(".")
    base = parts[: len(parts) - node.level + is_package] if node.level else []
    return ".".join([*base, *filter(None, [node.module])])


def import_graph(sources: Mapping[str, tuple[str, bool]], *, inside: bool) -> dict[str, set[str]]:
    """By module: the others of `sources` that it imports.

    Args:
        sources: By module, its text and whether it is a package.
        inside: Whether imports in functions, and those for type checkers, count.
    """
    graph: dict[str, set[str]] = {}
    for module, (text, is_package) in sources.items():
        imported: set[str] = set()
        for node in _imports(_tree(text), inside=inside):
            if isinstance(node, ast.Import):
                imported |= {alias.name for alias in node.names}
                continue
            origin = _absolute(node, module, is_package)
            inner = {f"{origin}.{alias.name}" for alias in node.names}  # modules of a package, or names in a module
            imported |= inner & set(sources) | ({origin} if inner - set(sources) else set())
        graph[module] = imported & set(sources) - {module}
    return graph


def floors(graph: Mapping[str, set[str]]) -> int:
    """How many modules the longest chain of imports has, the first and the last included."""
    depth: dict[str, int] = {}
    for module in TopologicalSorter(graph).static_order():
        depth[module] = 1 + max((depth[imported] for imported in graph[module]), default=0)
    return max(depth.values(), default=0)


def with_one_importer_beside(graph: Mapping[str, set[str]]) -> list[str]:
    """Modules that one other alone imports, which stands in the same folder; its `__init__` is in the folder too."""
    importers: dict[str, set[str]] = {module: set() for module in graph}
    for module, imported in graph.items():
        for name in imported:
            importers[name].add(module)
    return [
        module
        for module, (*others,) in importers.items()
        if len(others) == 1 and module.rpartition(".")[0] in (others[0], others[0].rpartition(".")[0])
    ]


def code_lines_in(text: str) -> int:
    """Lines that are neither blank nor a comment nor a docstring."""
    layout = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    lines = {line for token in tokens if token.type not in layout for line in range(token.start[0], token.end[0] + 1)}
    for node in ast.walk(_tree(text)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            lines -= set(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return len(lines)


def functions_in(text: str) -> int:
    """Functions and methods, those within others too."""
    return sum(isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) for node in ast.walk(_tree(text)))


def import_lines_in(text: str) -> int:
    """Lines on which an import stands, wherever it is."""
    nodes = _imports(_tree(text), inside=True)
    return len({line for node in nodes for line in range(node.lineno, (node.end_lineno or node.lineno) + 1)})


def forks() -> list[tuple[str, int]]:
    """File and line, wherever code outside the two worlds asks whether it has an arm or another environment."""
    return [
        (name, number)
        for path in files_of("harness", "plugins")
        if not WORLDS.match(name := path.relative_to(ROOT).as_posix())
        for number, line in enumerate(text_of(path).splitlines(), start=1)
        if FORK.search(line)
    ]


def _graph(*tops: str, inside: bool) -> dict[str, set[str]]:
    sources = {module_of(path): (text_of(path), path.stem == "__init__") for path in files_of(*tops)}
    return import_graph(sources, inside=inside)


@cache
def measured() -> dict[str, float]:
    """Every figure, by its name in `bounds.toml`."""
    core = files_of("harness")
    texts = [text_of(path) for path in core]
    code, asked = sum(map(code_lines_in, texts)), forks()
    return {
        "import floors": floors(_graph("harness", inside=False)),
        "functions a hundred lines of code": round(100 * sum(map(functions_in, texts)) / code, 1),
        "percent of the lines of code that import": round(100 * sum(map(import_lines_in, texts)) / code, 1),
        "modules with one importer in the same folder": len(
            with_one_importer_beside(_graph("harness", "plugins", inside=True))
        ),
        "files of harness": len(core),
        "lines of harness": lines_of(core),
        "lines of harness, plugins and robots": lines_of(files_of("harness", "plugins", "robots")),
        "lines that ask for the kind of world": len(asked),
        "files that ask for the kind of world": len({name for name, _ in asked}),
    }
