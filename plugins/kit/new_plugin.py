"""``harness new-plugin``: a package that works, for its author to change."""

import builtins
import importlib.util
import keyword
import re
import sys
import tempfile
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from string import Template
from typing import Annotated

import typer

from harness.cli.output import say
from harness.errors import UsageError
from harness.hookspecs import NOUNS, WORDS
from harness.registry import Registry, load_registry, unknown_name
from harness.text import command_text

_NAME = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")
LONGEST = 60


@dataclass(frozen=True)
class PluginName:
    """What users type, as ``my-reward``: words of lower-case letters and digits, joined by single hyphens.

    Such a name is its own normal form on a package index (PEP 503), and identifiers follow from it.

    Raises:
        UsageError: It is none, or the identifiers are taken.
    """

    text: str

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.text) or len(self.text) > LONGEST:
            raise UsageError(
                f"The name '{self.text}' must be words of lower-case letters and digits joined by '-', begin with a "
                f"letter and have at most {LONGEST} characters.{_suggestion(self.text)}"
            )
        owner = self._owner()
        if owner:
            raise UsageError(
                f"The name '{self.text}' becomes the module '{self.module}', which is {owner}: choose another name"
            )

    @property
    def module(self) -> str:
        """Import name of the package, ``my_reward``."""
        return self.text.replace("-", "_")

    @property
    def class_name(self) -> str:
        """The name of the class, ``MyReward``."""
        return "".join(word.capitalize() for word in self.text.split("-"))

    def _owner(self) -> str:
        """Who has the module's or the class's name already; empty if nobody."""
        if keyword.iskeyword(self.module) or hasattr(builtins, self.class_name):
            return "a word of Python"
        if self.module in sys.stdlib_module_names:
            return "a module of Python"
        if self.module == "tests":  # stands beside it
            return "the folder of its tests"
        return "a module that is installed" if importlib.util.find_spec(self.module) else ""


def _suggestion(text: str) -> str:
    near = re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")
    return f" Did you mean '{near}'?" if _NAME.fullmatch(near) and len(near) <= LONGEST else ""


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


NEXT = """{folder}: {count} files. Type next:

  {install}
  {test}
  {command}

The {noun} is {folder}/{module}/{kind}.py: change that file, and its tests beside it."""


def _kinds(incomplete: str) -> list[str]:
    """What a shell offers."""
    return [kind for kind in kinds() if kind.startswith(incomplete)]


def new_plugin(
    context: typer.Context,
    kind: Annotated[
        str,
        typer.Argument(
            help="algorithm, command, environment, executor, log, metric, reward, robot, simulator, task or tracker.",
            autocompletion=_kinds,
            metavar="KIND",
        ),
    ],
    name: Annotated[str, typer.Argument(help="The name that users will type, such as my-reward.", metavar="NAME")],
    into: Annotated[
        Path, typer.Option(help="The folder that the new package is made in.", show_default="here", metavar="DIR")
    ] = Path(),
) -> None:
    """Write a plugin's package: a working implementation, its tests, a README and a CI workflow."""
    folder = into / name
    require_new(folder)
    plugin = PluginName(name)
    files = package_files(kind, plugin)
    require_unclaimed(kind, plugin, load_registry())
    if kind == "command" and name in context.obj:
        raise UsageError(f"The name '{name}' is taken: it is a command of the harness. Choose another name")
    write_package(files, folder)
    install, test = command_text("pip", "install", "-e", Path(f"{folder}[test]")), command_text("pytest", folder)
    command = command_to_try(kind, plugin)
    noun = NOUNS[plural_of(kind)]
    words = {"folder": folder, "count": len(files), "install": install, "test": test, "command": command}
    say(NEXT.format(**words, noun=noun, kind=kind, module=plugin.module))


new_plugin.examples = (  # type: ignore[attr-defined] # harness shows them
    "harness new-plugin reward my-reward",
    "harness new-plugin simulator my-engine --into plugins",
)
