"""Names in what people read: what the pages, docstrings and comments call by a dotted name or a path exists."""

import ast
import importlib
import importlib.util
import inspect
import io
import re
import tokenize
import typing
from functools import cache
from pathlib import Path
from typing import NamedTuple

from harness.face import GONE, INSTEAD, LEFT, MOVED

ROOT = Path(__file__).parent.parent
HOMES = {"harness": ROOT / "harness", "harness_plugins": ROOT / "plugins", "harness_robots": ROOT / "robots"}
PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md")),
    *(
        path
        for folder in ("docs", "examples", "robots")
        for path in sorted((ROOT / folder).rglob("*.md"))
        if "generated" not in path.parts  # made from what is read here
    ),
]
MODULES = [path for home in (*HOMES.values(), ROOT / "examples") for path in sorted(home.rglob("*.py"))]

PACKAGE = f"(?:{'|'.join(HOMES)})"
DOTTED = re.compile(rf"(?<![\w./-]){PACKAGE}(?:\.[A-Za-z_]\w*)+(?![\w-]*[/-])")
MEMBER = re.compile(r"`([A-Z]\w*[a-z]\w*(?:\.[a-z_]\w*)+)")
FILE = re.compile(r"`((?:\w+/)*\w+\.py)`")
PYTHON = re.compile(r"^```python\n(.*?)^```", re.DOTALL | re.MULTILINE)
CLASS = re.compile(r"^class (\w+)", re.MULTILINE)

FILES_OF_READERS = {"behaviour.py"}
"""Files of the reader's own whose name means something to the harness."""
ENTRY_POINTS = {"harness.pytest_plugin"}
"""Names of entry points, which people type after ``-p`` of pytest, and which are no modules."""
EARLIER = {*MOVED, *INSTEAD, *LEFT, *GONE}
"""Names of earlier releases, which the code answers."""
FILE_ENDINGS = {"md", "toml", "json", "html"}
"""What makes ``harness.toml`` a file."""


class Name(NamedTuple):
    """A name, and the line where it stands."""

    line: int
    text: str


def wrong_names(text):
    """The names in a text that lead nowhere.

    These are: dotted names that begin with one of our packages, members of our classes such as `Policy.save` in
    backticks, paths of Python files in backticks, and in Python examples what they import of ours and take of that.
    """
    lines = list(enumerate(text.splitlines(), 1))
    dotted = [Name(line, name) for line, words in lines for name in DOTTED.findall(words) if not _is_file_name(name)]
    members = [Name(line, name) for line, words in lines for name in MEMBER.findall(words)]
    files = [Name(line, name) for line, words in lines for name in FILE.findall(words)]
    found = [name for name in (*dotted, *_names_in_examples(text)) if not _leads_somewhere(name.text)]
    found += [name for name in members if not _is_member(name.text)]
    files = [name for name in files if name.text not in FILES_OF_READERS]
    found += [name for name in files if not any((home / name.text).is_file() for home in (ROOT, HOMES["harness"]))]
    return sorted(set(found))


def _is_file_name(name):
    return name.rpartition(".")[2] in FILE_ENDINGS


def _names_in_examples(text):
    """What each Python example of a page imports of ours, and the attributes that it takes of that."""
    for example in PYTHON.finditer(text):
        before, tree = text[: example.start(1)].count("\n"), ast.parse(example[1])
        imported = {}
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.module and node.module.partition(".")[0] in HOMES:
                imported |= {alias.asname or alias.name: f"{node.module}.{alias.name}" for alias in node.names}
                yield from (Name(before + node.lineno, f"{node.module}.{alias.name}") for alias in node.names)
        for node in ast.walk(tree):
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in imported:
                yield Name(before + node.lineno, f"{imported[node.value.id]}.{node.attr}")


def _leads_somewhere(name):
    """Whether a dotted name goes from a package of ours to something that exists."""
    parts = name.split(".")
    if name in ENTRY_POINTS | EARLIER:
        return True
    for count in range(len(parts), 0, -1):
        module = ".".join(parts[:count])
        if _is_module(module):
            return _has(importlib.import_module(module), parts[count:])
    return False


@cache
def _is_module(name):
    try:
        return importlib.util.find_spec(name) is not None
    except ModuleNotFoundError:  # what stands before its last dot is no package
        return False


def _has(thing, attributes):
    """Whether the first of `attributes` is one of `thing`, the second one of that, and so on."""
    if not attributes:
        return True
    first, *others = attributes
    if hasattr(thing, first):
        return _has(getattr(thing, first), others)
    if not isinstance(thing, type):
        return False
    hints = typing.get_type_hints(thing)
    if first in hints:  # a field without a default
        return _has(hints[first], others)
    return not others and re.search(rf"\bself\.{first}\b[^=\n]*=[^=]", inspect.getsource(thing)) is not None


def _is_member(name):
    """Whether a class of ours has it; of a class that is not ours nothing is known."""
    homes = _homes_of_classes().get(name.partition(".")[0], [])
    return not homes or any(_leads_somewhere(f"{home}.{name}") for home in homes)


@cache
def _homes_of_classes():
    """By name of a class: the modules that define one."""
    homes = {}
    for package, folder in HOMES.items():
        for path in folder.rglob("*.py"):
            module = ".".join([package, *path.relative_to(folder).with_suffix("").parts]).removesuffix(".__init__")
            for name in CLASS.findall(path.read_text()):
                homes.setdefault(name, []).append(module)
    return homes


def prose_of(source):
    """The docstrings and comments of a module, each on its own lines, and nothing on the others."""
    code = source.splitlines()
    prose = [""] * len(code)
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            rows = slice(node.lineno - 1, node.end_lineno)
            prose[rows] = code[rows]
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            prose[token.start[0] - 1] = token.string
    return "\n".join(prose)


def test_every_name_that_people_read_exists():
    """In the pages, and in the docstrings and comments of the code."""
    texts = {path: path.read_text() for path in PAGES}
    texts |= {path: prose_of(path.read_text()) for path in MODULES}
    wrong = [
        f"{path.relative_to(ROOT)}:{name.line}: {name.text}"
        for path, text in texts.items()
        for name in wrong_names(text)
    ]
    assert len(texts) > 100
    assert not wrong, "\n".join(["names that do not exist:", *wrong])


WRONG = {
    "module": ("see `harness.tasks.Task`", "harness.tasks.Task"),
    "attribute": ("a `harness.task.ReachTusk`.", "harness.task.ReachTusk"),
    "attribute of an attribute": ("harness.policy.Policy.loads", "harness.policy.Policy.loads"),
    "behind a field": ("harness.record.cell.Cell.simulator.nome", "harness.record.cell.Cell.simulator.nome"),
    "instance": ("`harness.env.episodes.Episodes.flag`", "harness.env.episodes.Episodes.flag"),
    "plugin": ("`harness_plugins.rewards.app`", "harness_plugins.rewards.app"),
    "call": ("`harness.rum()`", "harness.rum"),
    "member": ("saved by `Policy.keep`", "Policy.keep"),
    "file": ("the loop of `harness/evaluate.py`", "harness/evaluate.py"),
    "import": ("```python\nfrom harness.task import ReechTask\n```", "harness.task.ReechTask"),
    "member in code": (
        "```python\nfrom harness.policy import Policy\n\nPolicy.loads(x)\n```",
        "harness.policy.Policy.loads",
    ),
}


def test_wrong_name_is_found_with_its_line(subtests):
    """The mutants: a slip in any part of a name."""
    for case, (text, name) in WRONG.items():
        with subtests.test(case):
            line = next(number for number, words in enumerate(text.splitlines(), 1) if name.rpartition(".")[2] in words)
            assert wrong_names(f"fine\n{text}\n") == [Name(line + 1, name)]


RIGHT = [
    "see harness.task.",
    "`harness.task.Task`",
    "``harness.experiment.plan.Experiment``",
    "harness.run(sim='mujoco')",
    "harness.record.cell.Cell.simulator.name",
    "harness.env.episodes.Episodes.flags",
    "`Policy.save`",
    "`Path.home`",
    "`harness/env/vector_env.py`, that is `env/vector_env.py`",
    "harness.toml",
    "my/harness.nothing/here",
    "the harness. And more",
]


def test_name_that_exists_is_left_alone(subtests):
    """Modules, classes, calls, fields without a default, attributes set in `__init__`, and what is no name of ours."""
    for text in RIGHT:
        with subtests.test(text=text):
            assert wrong_names(text) == []


def test_prose_is_docstrings_and_comments():
    """Each on the line where it stands; the rest of the code is no prose."""
    source = 'harness.a\n\ndef f():\n    """harness.b"""\n    x = "harness.c"  # harness.d\n'
    assert prose_of(source).split("\n") == ["", "", "", '    """harness.b"""', "# harness.d"]
