"""A plugin's package: its files from the templates, and how they get onto the disk.

Each folder of `templates` is a kind of plugin; what stands in ``common`` is part of all. Its ``kind.toml`` has the words
that the common files take: `summary` for ``harness list``, `command` to try the plugin with, `target`, what its module
defines, `tests`, what its tests are, and `data`, the part of ``pyproject.toml`` for files that are no Python.
"""

import re
import tempfile
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from string import Template

from harness.errors import UsageError
from harness.hookspecs import NOUNS
from harness.registry.registry import unknown_name
from harness.scaffold.plugin_name import PluginName

TEMPLATES = Path(__file__).parent / "templates"
SUFFIX = ".template"
"""So that no tool takes a template for Python."""
COMMON = "common"
MODULE, DOT = "package/", "dot_"
"""In a template's path: the folder that gets the module's name, and what stands for a leading dot."""
CONSTANT = "FOLDER"
"""A target that is called so whatever the plugin is called."""
DEFAULTS = {"target": "$Class", "tests": "the contract kit, and a test of what it says", "data": ""}


def kinds() -> list[str]:
    """The kinds of plugin that there are templates for, as ``reward``, sorted."""
    return sorted(folder.name for folder in TEMPLATES.iterdir() if folder.name != COMMON)


def package_files(kind: str, name: PluginName) -> dict[str, str]:
    """A working plugin: what to write, by path in its folder.

    Args:
        kind: One of `kinds`.
        name: Of the plugin.

    Raises:
        UsageError: There is no such kind, or its code uses the name for something else.
    """
    if kind not in kinds():
        raise UsageError(unknown_name("kind of plugin", kind, kinds()))
    templates, words = dict(_templates(kind)), _words(kind, name)
    _require_free(name, words["target"], templates.values())
    return {path.replace(MODULE, f"{name.module}/"): Template(text).substitute(words) for path, text in templates.items()}


def command_to_try(kind: str, name: PluginName) -> str:
    """What to type when the plugin is installed."""
    return _words(kind, name)["command"]


def write_package(files: Mapping[str, str], folder: Path) -> None:
    """Write a package's files into a new folder, all of them or none.

    Raises:
        UsageError: The folder is there already, or cannot be made there.
    """
    if folder.exists() or folder.is_symlink():
        raise UsageError(f"'{folder}' is there already, and nothing is written over: choose another name, or --into DIR")
    if not folder.parent.is_dir():
        raise UsageError(f"'{folder.parent}' is no folder: make it first, or name another after --into")
    with tempfile.TemporaryDirectory(dir=folder.parent, prefix=f".{folder.name}-") as draft:
        whole = Path(draft) / folder.name
        for path, text in files.items():
            file = whole / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
        whole.rename(folder)


def _templates(kind: str) -> Iterator[tuple[str, str]]:
    """The files of a kind: path in the package, and text with placeholders."""
    for root in (TEMPLATES / COMMON, TEMPLATES / kind):
        for file in sorted(root.rglob(f"*{SUFFIX}")):
            path = file.relative_to(root).as_posix().removesuffix(SUFFIX)
            yield path.replace(DOT, "."), file.read_text(encoding="utf-8")


def _words(kind: str, name: PluginName) -> dict[str, str]:
    """What the placeholders stand for."""
    own = {
        "name": name.text,
        "module": name.module,
        "Class": name.class_name,
        "noun": kind,
        "article": "An" if kind[0] in "aeiou" else "A",
        "hook": next(f"register_{kinds}" for kinds, noun in NOUNS.items() if noun == kind),
    }
    told = tomllib.loads((TEMPLATES / kind / "kind.toml").read_text(encoding="utf-8"))
    return own | {word: Template(text).substitute(own) for word, text in (DEFAULTS | told).items()}


def _require_free(name: PluginName, target: str, texts: Iterable[str]) -> None:
    """See that what the module defines is called so alone; a placeholder, as in ``$Class``, is no use of a name."""
    if any(re.search(rf"(?<![$\w]){target}\b", text) for text in texts if target != CONSTANT):
        raise UsageError(f"The name '{name.text}' would make '{target}' mean two things in its code: choose another")
