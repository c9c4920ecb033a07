"""Plugins that are given by hand, without an installation: a Python file, or a class that can be imported.

They travel as data to the processes and machines that do the work: a file with its text, a class by its name.
"""

import hashlib
import importlib
import importlib.util
import inspect
import os
import re
import shlex
import sys
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, TypeAlias

from harness.errors import UsageError, one_line
from harness.files.bounded import read_text
from harness.hookspecs import NOUNS
from harness.registry.hooks import fault_of, hooks_of
from harness.registry.members import MEMBERS, missing_members, sample_of
from harness.registry.spec import Spec

MOST_BYTES = 2**20
"""Of a file with plugins."""
ENDING = ".py"
_MODULE_PREFIX = "harness_file_"
_CLASS = re.compile(r"[A-Za-z_][\w.]*:[A-Za-z_]\w*")


@dataclass(frozen=True)
class PluginFile:
    """A Python file that registers plugins, as it was when it was read.

    Attributes:
        path: Where it was, in full.
        source: Its text.
    """

    path: str
    source: str

    @property
    def name(self) -> str:
        """Of the file, without its folder: what stands for the distribution."""
        return Path(self.path).name

    @property
    def digest(self) -> str:
        """SHA-256 of its bytes."""
        return hashlib.sha256(self.source.encode()).hexdigest()

    @property
    def module(self) -> str:
        """What it is imported as: no installed module has the name, and an edited file has another."""
        return f"{_MODULE_PREFIX}{re.sub(r'[^A-Za-z0-9_]', '_', Path(self.path).stem)}_{self.digest[:8]}"

    @property
    def need(self) -> dict[str, str]:
        """What an experiment file says of it."""
        return {"path": self.path, "sha256": self.digest}


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


def given_to_json(given: Iterable[Given]) -> list[dict[str, str]]:
    """Plain data; `given_from_json` gives the same back."""
    return [asdict(it) for it in given]


def given_from_json(data: Iterable[Mapping[str, str]]) -> tuple[Given, ...]:
    """What `given_to_json` told."""
    return tuple(PluginFile(**it) if "path" in it else PluginClass(**it) for it in data)


def read_given(asked: Iterable[str | Path | type] | None) -> tuple[Given, ...]:
    """What ``--plugin`` or ``plugins=[...]`` names: paths of files, classes, or classes as ``"module:Class"``.

    Raises:
        UsageError: There is no such file, it cannot be read, two have one name, or the class fits no kind.
    """
    given = tuple(dict.fromkeys(_read(item) for item in asked or ()))
    names = [it.name for it in given]
    for name in names:
        if names.count(name) > 1:
            paths = " and ".join(f"'{it.path}'" for it in given if isinstance(it, PluginFile) and it.name == name)
            raise UsageError(f"Two plugin files are called {name}: {paths}. Rename one")
    return given


def is_class_name(text: str) -> bool:
    """Whether a text names a class, ``module:Class``, and not a file."""
    return _CLASS.fullmatch(text) is not None


def _read(asked: str | Path | type) -> Given:
    if inspect.isclass(asked):
        return class_given(asked)
    text = str(asked)
    if isinstance(asked, str) and is_class_name(text):
        return class_given(_import_class(text))
    path = Path(os.path.abspath(text))
    if path.suffix != ENDING:
        raise UsageError(f"'{text}' is no plugin: give a Python file, my_reward{ENDING}, or a class, module:Class")
    try:
        return PluginFile(str(path), read_text(path, MOST_BYTES))
    except (OSError, ValueError) as error:
        problem = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise UsageError(f"Plugin file '{text}' cannot be read: {problem}") from None


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
    file = f"my_{NOUNS.get(kind or '', 'plugin')}{ENDING}"
    save = f"save it as a file and give plugins=['{file}']"
    if module == "__main__" or getattr(sys.modules.get(module), "__spec__", None) is None:
        raise UsageError(f"{name} is defined in a notebook or script, where no worker process finds it: {save}")
    if "." in name:
        raise UsageError(f"{module}.{name} is defined inside a function or a class, where nobody can import it: {save}")
    return PluginClass(_kind_of(found, name, kind), f"{module}:{name}")


def _kind_of(found: type, name: str, kind: str | None = None) -> str:
    """The one kind that a class fits by its members."""
    sample = sample_of(found)
    faults = {one: missing_members(one, sample) for one in ([kind] if kind else MEMBERS)}
    fitting = [one for one, fault in faults.items() if not fault]
    if len(fitting) == 1:
        return fitting[0]
    if fitting:
        raise UsageError(f"{name} fits several kinds, {' and '.join(fitting)}: register it by a hook")
    nearest = max(faults, key=lambda one: _share_of_members(one, sample))
    raise UsageError(f"{name} {faults[nearest]}")


def _share_of_members(kind: str, sample: Any) -> float:
    return sum(hasattr(sample, name) for name in MEMBERS[kind]) / len(MEMBERS[kind])


def import_file(file: PluginFile) -> ModuleType:
    """The file's module, imported once in a process.

    Raises:
        UsageError: It raises, or cannot be understood; its hooks are none that exist.
    """
    if file.module in sys.modules:
        return sys.modules[file.module]
    spec = importlib.util.spec_from_file_location(file.module, _copy_of(file))
    assert spec is not None
    module = sys.modules[file.module] = importlib.util.module_from_spec(spec)
    try:
        # Compiled here: Python would leave its own copy beside the file, and might believe an old one.
        exec(compile(file.source.encode(), file.path, "exec", dont_inherit=True), vars(module))
    except (Exception, SystemExit) as error:
        del sys.modules[file.module]
        problem = f"{one_line(error)}{_line_of(error, file.path)}"
        raise UsageError(f"Plugin file '{file.path}' cannot be loaded: {problem}") from None
    fault = fault_of(module) if hooks_of(module) else ""
    if fault:
        del sys.modules[file.module]
        raise UsageError(f"Plugin file '{file.path}': {fault}")
    return module


def is_plugin_file(module: str) -> bool:
    """Whether a module was imported from a plugin file. It never changes: another text is a module of another name."""
    return module.startswith(_MODULE_PREFIX)


def _line_of(error: BaseException, path: str) -> str:
    """The last line of the file that was reached."""
    trace, line = error.__traceback__, 0
    while trace is not None:
        line = trace.tb_lineno if trace.tb_frame.f_code.co_filename == path else line
        trace = trace.tb_next
    return f" (line {line})" if line else ""


def class_of_file(file: PluginFile, module: ModuleType) -> Spec:
    """What a file without hooks registers: its one public class, under the name of the file.

    Raises:
        UsageError: It has none or several, or the class fits no kind.
    """
    classes = [
        it
        for name, it in vars(module).items()
        if inspect.isclass(it) and it.__module__ == file.module and not name.startswith("_")
    ]
    if len(classes) != 1:
        names = ", ".join(it.__name__ for it in classes) or "none"
        raise UsageError(
            f"Plugin file '{file.path}' registers nothing: without hooks it needs one public class, it has {names}. "
            "Begin the names of others with _, or register by @harness.hookimpl"
        )
    (found,) = classes
    try:
        kind = _kind_of(found, found.__name__)
    except UsageError as error:
        raise UsageError(f"Plugin file '{file.path}': {error}") from None
    summary = next(iter(inspect.cleandoc(found.__doc__ or "").splitlines()), "")
    name = Path(file.path).stem.lower()
    return Spec(kind, name, f"{file.module}:{found.__name__}", summary, (), None, file.name, file.name)


def require_given(needs: Sequence[str | Mapping[str, Any]], given: Sequence[Given]) -> None:
    """See that what an experiment file names is given.

    A file is never loaded because an experiment file names it: who runs one that others wrote says so by hand.

    Raises:
        UsageError: Something is not; says what to give.
    """
    names = {it.name for it in given}
    for need in needs:
        what, digest = _what_to_give(need), "" if isinstance(need, str) else str(need.get("sha256", ""))
        if not what:
            raise UsageError(f"plugins: {need!r} names nothing: write the path of a file, or {{path = '...'}}")
        if Path(what).name not in names:
            which = f" (SHA-256 {digest[:8]})" if digest else ""
            raise UsageError(f"The experiment needs the plugin {Path(what).name}{which}: give{plugin_flags([need])}")


def plugin_flags(needs: Any) -> str:
    """The ``--plugin`` flags that give what an experiment file names, quoted for a shell: `` --plugin my_reward.py``.

    Each flag follows a blank, so that the text can be appended to a command. The text is empty if nothing is named.

    Args:
        needs: The key ``plugins`` of an experiment. Other people's files may hold anything there: what names no plugin
            is left out.
    """
    named = [need for need in needs if isinstance(need, str | dict)] if isinstance(needs, list) else []
    return "".join(f" --plugin {shlex.quote(what)}" for what in map(_what_to_give, named) if what)


def _what_to_give(need: str | Mapping[str, Any]) -> str:
    """What ``--plugin`` has to name: the path of a file, or ``module:Class``; empty if the table names neither."""
    told = {"path": need} if isinstance(need, str) else need
    return str(told.get("path") or told.get("target") or "")


def _copy_of(file: PluginFile) -> Path:
    """The text as a file of this process, which nobody edits or removes while its digest is asked for."""
    copy = Path(_own_folder().name) / f"{file.digest[:8]}-{file.name}"
    copy.write_text(file.source, encoding="utf-8", newline="")
    return copy


@cache
def _own_folder() -> "tempfile.TemporaryDirectory[str]":
    """Removed when this process ends."""
    return tempfile.TemporaryDirectory(prefix="harness-plugins-")
