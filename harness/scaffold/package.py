"""A plugin's package: its files from the templates, and how they get onto the disk.

Each folder of `templates` is a kind of plugin, and ``common`` is part of all. A kind's ``kind.toml`` has the words that
common files take: `summary` for ``harness list``; `command`, to try the plugin with; `target`, what its module defines;
`tests`, what its tests are; and `data`, the part of ``pyproject.toml`` for files that are no Python.
"""

import re
import tempfile
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from string import Template

from harness.errors import UsageError
from harness.hookspecs import NOUNS, WORDS
from harness.registry.names import unknown_name
from harness.registry.registry import Registry
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
    filled = {path: Template(text).substitute(words) for path, text in templates.items()}
    return {path.replace(MODULE, f"{name.module}/"): text for path, text in filled.items()}


def command_to_try(kind: str, name: PluginName) -> str:
    """What to type when the plugin is installed."""
    return _words(kind, name)["command"]


def require_new(folder: Path) -> None:
    """See that a folder can be made.

    Raises:
        UsageError: It is there already, or the folder to hold it is not.
    """
    if folder.exists() or folder.is_symlink():
        raise UsageError(
            f"'{folder}' is there already, and nothing is written over: choose another name, or --into DIR"
        )
    if not folder.parent.is_dir():
        raise UsageError(f"'{folder.parent}' is no folder: make it first, or name another after --into")


def require_unclaimed(kind: str, name: PluginName, registry: Registry) -> None:
    """See that nobody else's plugin has the name: two that claim one name stand in each other's way.

    Raises:
        UsageError: Something of this kind, or another plugin, is called so; names whose it is.
    """
    plural = plural_of(kind)
    claims = registry.specs.get((plural, name.text), [])
    owners = [f"a {NOUNS[plural]} of '{spec.plugin}' ({spec.distribution})" for spec in claims]
    owners += [f"a plugin of {plugin.distribution}" for plugin in registry.plugins if plugin.name == name.text]
    if owners:
        raise UsageError(f"The name '{name.text}' is taken: there is {owners[0]} of that name. Choose another name")


def plural_of(kind: str) -> str:
    """The plural by which the hooks and the registry call a kind, ``rewards``."""
    return next(plural for plural, word in WORDS.items() if word == kind)


def write_package(files: Mapping[str, str], folder: Path) -> None:
    """Write a package's files into a new folder, all of them or none.

    Raises:
        UsageError: See `require_new`.
    """
    require_new(folder)
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
    plural = plural_of(kind)
    own = {
        "name": name.text,
        "module": name.module,
        "Class": name.class_name,
        "kind": kind,
        "noun": NOUNS[plural],
        "article": "An" if kind[0] in "aeiou" else "A",
        "hook": f"register_{plural}",
    }
    told = tomllib.loads((TEMPLATES / kind / "kind.toml").read_text(encoding="utf-8"))
    return own | {word: Template(text).substitute(own) for word, text in (DEFAULTS | told).items()}


def _require_free(name: PluginName, target: str, texts: Iterable[str]) -> None:
    """See that what the module defines is called so alone; a placeholder, as in ``$Class``, is no use of a name."""
    if any(re.search(rf"(?<![$\w]){target}\b", text) for text in texts if target != CONSTANT):
        raise UsageError(
            f"The name '{name.text}' would make '{target}' mean two things in its code: choose another name"
        )
