"""Plugins that are given by hand, without an installation: a Python file, or a class that can be imported.

They travel as data to the processes and machines that do the work: a file with its text, a class by its name.
"""

import glob
import hashlib
import importlib
import inspect
import os
import re
import shlex
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from harness.errors import UsageError, one_line
from harness.files.bounded import read_text
from harness.hookspecs import WORDS
from harness.registry.members import MEMBERS, missing_members, sample_of
from harness.registry.sources import imports_of
from harness.registry.spec import Spec

MOST_BYTES = 2**20
"""The most bytes of a file with plugins."""
MOST_BESIDE = 100
"""Files beside it that a file may import."""
ENDING = ".py"
BEHAVIOUR = ("behaviour", "behavior")
"""Names of files whose functions measure what a robot does."""
MODULE_PREFIX = "harness_file_"
"""Begins the names of modules that are imported from plugin files."""
_PATTERN = re.compile(r"[*?\[]")
_CLASS = re.compile(r"[A-Za-z_][\w.]*:[A-Za-z_]\w*")


@dataclass(frozen=True)
class PluginFile:
    """A Python file that registers plugins, as it was when it was read.

    Attributes:
        path: Where it was, in full.
        source: Its text.
        beside: The modules in its folder that it imports, directly or through one another: name and text, by name.
        measures: Whether its functions measure what a robot does, and are no rewards.
        optional: Whether a pattern such as ``rewards/*.py`` found it: if it cannot be used, the others go on.
        left_out: Names of functions in it that are not used, because they failed when they were tried.
    """

    path: str
    source: str
    beside: tuple[tuple[str, str], ...] = ()
    measures: bool = False
    optional: bool = False
    left_out: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The name of the file, without its folder: it stands for the distribution."""
        return Path(self.path).name

    @property
    def text(self) -> str:
        """Its text, followed by that of the modules beside it."""
        return "".join([self.source, *(text for _, text in self.beside)])

    @property
    def digest(self) -> str:
        """SHA-256 of `text` in UTF-8."""
        return hashlib.sha256(self.text.encode()).hexdigest()

    @property
    def stem(self) -> str:
        """Its name without the ending."""
        return Path(self.path).stem

    @property
    def module(self) -> str:
        """What it is imported as: no installed module has the name, and an edited file has another."""
        return f"{MODULE_PREFIX}{re.sub(r'[^A-Za-z0-9_]', '_', self.stem)}_{self.digest[:8]}"

    @property
    def need(self) -> dict[str, Any]:
        """What an experiment file says of it."""
        told = {"measures": True} if self.measures and self.stem not in BEHAVIOUR else {}
        return {"path": self.path, "sha256": self.digest, **told}


@dataclass(frozen=True)
class PluginClass:
    """A class that a worker can import.

    Attributes:
        kind: ``rewards`` and so on.
        target: ``module:Class``.
    """

    kind: str
    target: str

    @property
    def name(self) -> str:
        """The same."""
        return self.target

    @property
    def need(self) -> dict[str, str]:
        """What an experiment file says of it."""
        return {"target": self.target}

    @property
    def spec(self) -> Spec:
        """It is known by its module and its own name, ``my_package.rewards/MyReward``."""
        module, name = self.target.split(":")
        return Spec(self.kind, name, self.target, "given by hand", (), None, module, module)


Given: TypeAlias = PluginFile | PluginClass


def read_given(
    asked: Iterable[str | Path | type] | None, measures: Iterable[str | Path] | None = None
) -> tuple[Given, ...]:
    """What ``--plugin`` or ``plugins=[...]`` names.

    Args:
        asked: Paths of files, patterns of such (``rewards/*.py``), classes, or classes as ``"module:Class"``.
        measures: Paths of files whose functions measure what a robot does. So do those of files that are called
            ``behaviour.py``, wherever they are named.

    Raises:
        UsageError: There is no such file, it cannot be read, two have one name, or the class fits no kind.
    """
    files = [read for item in asked or () for read in _read_all(item)]
    of_measures = [_read_file(str(item), measures=True) for item in measures or ()]
    again = {it.path for it in of_measures}
    given = tuple(dict.fromkeys([*(it for it in files if getattr(it, "path", None) not in again), *of_measures]))
    names = [it.name for it in given]
    for name in names:
        if names.count(name) > 1:
            paths = " and ".join(f"'{it.path}'" for it in given if isinstance(it, PluginFile) and it.name == name)
            raise UsageError(f"Two plugin files are called {name}: {paths}. Rename one")
    return given


def split_measures(asked: str | Sequence[str | Path]) -> tuple[list[str], list[str]]:
    """What ``--measure`` names: names of measures, and paths of Python files whose functions are measures."""
    listed = [asked] if isinstance(asked, str) else asked
    parts = [part.strip() for item in listed for part in str(item).split(",") if part.strip()]
    return [it for it in parts if not it.endswith(ENDING)], [it for it in parts if it.endswith(ENDING)]


def is_class_name(text: str) -> bool:
    """Whether a text names a class, ``module:Class``, and not a file."""
    return _CLASS.fullmatch(text) is not None


def _read_all(asked: str | Path | type) -> list[Given]:
    if inspect.isclass(asked):
        return [class_given(asked)]
    text = str(asked)
    if isinstance(asked, str) and is_class_name(text):
        return [class_given(_import_class(text))]
    if _PATTERN.search(text) and not os.path.exists(text):
        return [*_matched(text)]
    return [_read_file(text)]


def _matched(pattern: str) -> list[PluginFile]:
    """The files of a pattern, by path; a file that one of them imports counts too if it matches."""
    found = sorted(path for path in glob.glob(os.path.expanduser(pattern), recursive=True) if os.path.isfile(path))
    files = [path for path in found if path.endswith(ENDING) and not Path(path).name.startswith("_")]
    if not files:
        raise UsageError(
            f"No Python file matches '{pattern}'. Names that begin with _ are left out: files that others import"
        )
    return [_read_file(path, optional=True) for path in files]


def _read_file(text: str, measures: bool = False, optional: bool = False) -> PluginFile:
    path = Path(os.path.abspath(os.path.expanduser(text)))
    if path.suffix != ENDING:
        raise UsageError(
            f"'{text}' is no Python file: give one, my_reward{ENDING}, a pattern of such, 'rewards/*{ENDING}', "
            "or a class, module:Class"
        )
    try:
        source = read_text(path, MOST_BYTES)
    except (OSError, ValueError) as error:
        problem = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise UsageError(f"Plugin file '{text}' cannot be read: {problem}") from None
    beside = tuple(sorted(_beside(path, source).items()))
    return PluginFile(str(path), source, beside, measures or path.stem in BEHAVIOUR, optional)


def _beside(path: Path, source: str) -> dict[str, str]:
    """The files beside one that it imports, and those that these import: name of the module and text."""
    found: dict[str, str] = {}
    waiting = [source]
    while waiting:
        for name in sorted(_tops_imported(waiting.pop())):
            file = path.with_name(f"{name}{ENDING}")
            if name in found or name in sys.stdlib_module_names or file == path or not file.is_file():
                continue
            try:
                found[name] = read_text(file, MOST_BYTES)
            except (OSError, ValueError) as error:
                raise UsageError(f"Plugin file '{path}' imports '{file}', which cannot be read: {error}") from None
            if len(found) > MOST_BESIDE or sum(map(len, found.values())) > MOST_BYTES:
                most = f"{MOST_BESIDE} files and {MOST_BYTES:,} characters"
                raise UsageError(f"Plugin file '{path}' imports more than {most} beside it: install them as a package")
            waiting.append(found[name])
    return found


def _tops_imported(source: str) -> set[str]:
    """The first parts of all names that a source imports; none if it cannot be parsed, which its import will tell."""
    try:
        return {name.lstrip(".").partition(".")[0] for name in imports_of(source.encode(), "")}
    except (SyntaxError, ValueError):
        return set()


def _import_class(target: str) -> Any:
    module, name = target.split(":")
    try:
        return getattr(importlib.import_module(module), name)
    except (Exception, SystemExit) as error:
        raise UsageError(f"Plugin '{target}' cannot be imported: {one_line(error)}") from None


def class_given(found: Any, kind: str | None = None) -> PluginClass:
    """A class, if a worker process can import it.

    Args:
        found: The class.
        kind: What it has to be, ``rewards``; found out by its members if None.

    Raises:
        UsageError: It is defined where no other process finds it, or fits no kind.
    """
    name, module = found.__qualname__, found.__module__
    file = f"my_{WORDS.get(kind or '', 'plugin')}{ENDING}"
    save = f"save it as a file and give plugins=['{file}']"
    if module == "__main__" or getattr(sys.modules.get(module), "__spec__", None) is None:
        raise UsageError(f"{name} is defined in a notebook or script, where no worker process finds it: {save}")
    if "." in name:
        raise UsageError(f"{module}.{name} is defined inside a function or a class, where nobody can import it: {save}")
    return PluginClass(kind_of(found, name, kind), f"{module}:{name}")


def kind_of(found: type, name: str, kind: str | None = None) -> str:
    """The one kind that a class fits by its members."""
    sample = sample_of(found)
    faults = {one: missing_members(one, sample) for one in ([kind] if kind else MEMBERS)}
    fitting = [one for one, fault in faults.items() if not fault]
    if len(fitting) == 1:
        return fitting[0]
    if fitting:
        raise UsageError(f"{name} fits several kinds, {' and '.join(fitting)}: register it by a hook")
    nearest = max(faults, key=lambda one: sum(hasattr(sample, name) for name in MEMBERS[one]) / len(MEMBERS[one]))
    raise UsageError(f"{name} {faults[nearest]}")


def is_plugin_file(module: str) -> bool:
    """Whether a module was imported from a plugin file. It never changes: another text is a module of another name."""
    return module.startswith(MODULE_PREFIX)


def require_given(
    needs: Sequence[str | Mapping[str, Any]], given: Sequence[Given], what: str = "The experiment"
) -> None:
    """See that what an experiment file names is given.

    A file is never loaded because an experiment file names it: who runs one that others wrote says so by hand.

    Args:
        needs: What it names.
        given: What the user gave.
        what: Needs it.

    Raises:
        UsageError: Something is not; says what to give.
    """
    names = {it.name for it in given}
    for need in needs:
        named, digest = _what_to_give(need), "" if isinstance(need, str) else str(need.get("sha256", ""))
        if not named:
            raise UsageError(f"plugins: {need!r} names nothing: write the path of a file, or {{path = '...'}}")
        if Path(named).name not in names:
            which = f" (SHA-256 {digest[:8]})" if digest else ""
            raise UsageError(f"{what} needs the plugin {Path(named).name}{which}: give{plugin_flags([need])}")


def plugin_flags(needs: Any, for_report: bool = False) -> str:
    """The flags that give what an experiment file names, quoted for a shell: `` --plugin my_reward.py``.

    Each flag follows a blank, so that the text can be appended to a command. The text is empty if nothing is named.

    Args:
        needs: The key ``plugins`` of an experiment. Other people's files may hold anything there: what names no plugin
            is left out.
        for_report: Leave out files of functions: what they said of each step is recorded.
    """
    named = [need for need in needs if isinstance(need, str | dict)] if isinstance(needs, list) else []
    if for_report:
        named = [need for need in named if isinstance(need, str) or need.get("functions") is not True]
    given = [(_what_to_give(need), not isinstance(need, str) and need.get("measures") is True) for need in named]
    return "".join(f" {'--measure' if is_measure else '--plugin'} {shlex.quote(it)}" for it, is_measure in given if it)


def _what_to_give(need: str | Mapping[str, Any]) -> str:
    """What ``--plugin`` has to name: the path of a file, or ``module:Class``; empty if the table names neither."""
    told = {"path": need} if isinstance(need, str) else need
    return str(told.get("path") or told.get("target") or "")
