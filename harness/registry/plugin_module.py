"""Imports a plugin file from its text, and the files beside it that it imports.

The files beside it stand in no folder that Python searches. They are imported for this plugin file alone, so that two
plugin files may each have a file of one name beside them, and an installed module of that name stays what it is.
"""

import builtins
import importlib.util
import inspect
import linecache
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from contextlib import chdir, suppress
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

from harness.errors import UsageError, one_line
from harness.registry.given import ENDING, PluginFile, kind_of
from harness.registry.sources import BESIDE
from harness.registry.spec import Spec, fault_of, hooks_of

COPIES = "harness-plugins-"
"""What the names of folders with copies of plugin files begin with; the number of the process follows."""
OLD = 86_400.0
"""The age of a folder, [s], from which on it may be what a killed process left."""
OF_FILE = "__harness_file__"
"""The attribute of the module of a plugin file that holds the `PluginFile`."""


def import_file(file: PluginFile) -> ModuleType:
    """The file's module, imported once in a process.

    Raises:
        UsageError: It raises, or cannot be understood; its hooks are none that exist.
    """
    if file.module in sys.modules:
        return sys.modules[file.module]
    module = _module(file.module, _copy(file, file.stem, file.source))
    setattr(module, OF_FILE, file)
    setattr(module, BESIDE, [_copy(file, name, text) for name, text in file.beside])
    try:
        with chdir("."):  # the file may change it
            _execute(module, file.source, file.path, _importer(file))
    except (Exception, SystemExit) as error:
        _forget(file)
        problem = f"{one_line(error)}{_line_of(error, file)}"
        raise UsageError(f"Plugin file '{file.path}' cannot be loaded: {problem}") from None
    fault = fault_of(module) if hooks_of(module) else ""
    if fault:
        _forget(file)
        raise UsageError(f"Plugin file '{file.path}': {fault}")
    return module


def file_behind(defined: Any) -> PluginFile | None:
    """The plugin file that defines a function or a class, in the file itself or in one beside it; None if none does."""
    module = sys.modules.get(getattr(defined, "__module__", None) or "")
    return getattr(module, OF_FILE, None)


def _module(name: str, copy: Path) -> ModuleType:
    """An empty module. Its file is a copy, which nobody edits or removes while its digest is asked for."""
    spec = importlib.util.spec_from_file_location(name, copy)
    assert spec is not None
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    return module


def _execute(module: ModuleType, source: str, path: str, find: Callable[..., Any]) -> None:
    # Functions look up `__import__` in the built-ins of the module that defines them.
    module.__dict__["__builtins__"] = {**vars(builtins), "__import__": find}
    # Tracebacks and `inspect` show the text that runs, whatever becomes of the file. No time of change: it stays.
    linecache.cache[path] = (len(source), None, source.splitlines(keepends=True), path)
    # Compiled here: Python would leave its own copy beside the file, and might believe an old one.
    exec(compile(source.encode(), path, "exec", dont_inherit=True), vars(module))


def _importer(file: PluginFile) -> Callable[..., Any]:
    """What ``import`` does in a plugin file and in the files beside it."""
    beside: Mapping[str, str] = dict(file.beside)

    def find(
        name: str, names: Any = None, inner: Any = None, fromlist: tuple[str, ...] | None = (), level: int = 0
    ) -> Any:
        first = name.partition(".")[0]
        if level == 0 and first not in beside:
            return builtins.__import__(name, names, inner, fromlist or (), level)
        if level == 1 and not name:  # from . import helpers
            here = ModuleType(f"{file.module}.")
            vars(here).update({one: load(one) for one in fromlist or ()})
            return here
        if level > 1 or name not in beside:
            raise ModuleNotFoundError(f"No module named {'.' * level + name!r} beside it", name=name)
        return load(name)

    def load(name: str) -> ModuleType:
        whole = f"{file.module}.{name}"
        if whole in sys.modules:
            return sys.modules[whole]
        if name not in beside:
            raise ModuleNotFoundError(f"No module named {name!r} beside it", name=name)
        module = _module(whole, _copy(file, name, beside[name]))
        setattr(module, OF_FILE, file)
        try:
            _execute(module, beside[name], _path_beside(file, name), find)
        except BaseException:
            del sys.modules[whole]
            raise
        return module

    return find


def _forget(file: PluginFile) -> None:
    for name in [name for name in sys.modules if name == file.module or name.startswith(f"{file.module}.")]:
        del sys.modules[name]


def _line_of(error: BaseException, file: PluginFile) -> str:
    """The last line of the file, or of one beside it, that was reached."""
    trace, told = error.__traceback__, ""
    names = {file.path: "", **{_path_beside(file, name): f" of {name}{ENDING}" for name, _ in file.beside}}
    while trace is not None:
        path = trace.tb_frame.f_code.co_filename
        told = f" (line {trace.tb_lineno}{names[path]})" if path in names else told
        trace = trace.tb_next
    return told


def class_of_file(file: PluginFile, module: ModuleType) -> Spec:
    """What a file without hooks registers: its one public class, under the name of the file.

    Raises:
        UsageError: It has none or several, or the class fits no kind.
    """
    classes = public_classes(file, module)
    if len(classes) != 1:
        names = ", ".join(it.__name__ for it in classes) or "none"
        raise UsageError(
            f"Plugin file '{file.path}' registers nothing: without hooks it needs one public class, it has {names}. "
            "Begin the names of others with _, or register by @harness.hookimpl"
        )
    (found,) = classes
    try:
        kind = kind_of(found, found.__name__)
    except UsageError as error:
        raise UsageError(f"Plugin file '{file.path}': {error}") from None
    summary = next(iter(inspect.cleandoc(found.__doc__ or "").splitlines()), "")
    return Spec(kind, file.stem.lower(), f"{file.module}:{found.__name__}", summary, (), None, file.name, file.name)


def public_classes(file: PluginFile, module: ModuleType) -> list[type]:
    """The classes that a file defines, but for those whose names begin with ``_``."""
    return [
        it
        for name, it in vars(module).items()
        if inspect.isclass(it) and it.__module__ == file.module and not name.startswith("_")
    ]


def _path_beside(file: PluginFile, name: str) -> str:
    return str(Path(file.path).with_name(f"{name}{ENDING}"))


def _copy(file: PluginFile, name: str, text: str) -> Path:
    """The copy of a file, or of one beside it."""
    copy = _folder_of(file) / f"{name}{ENDING}"
    copy.write_text(text, encoding="utf-8", newline="")
    return copy


def _folder_of(file: PluginFile) -> Path:
    """The folder of the copies of a file and of those beside it; it is removed when this process ends."""
    folder = Path(_own_folder().name) / file.digest[:16]
    folder.mkdir(exist_ok=True)
    return folder


@cache
def _own_folder() -> "tempfile.TemporaryDirectory[str]":
    """One for this process. Those of processes that were killed, which removed none, are removed first."""
    for left in Path(tempfile.gettempdir()).glob(f"{COPIES}*"):
        if _is_left(left):
            shutil.rmtree(left, ignore_errors=True)  # another user's stays
    return tempfile.TemporaryDirectory(prefix=f"{COPIES}{os.getpid()}-")


def _is_left(folder: Path) -> bool:
    """Whether a folder is old, and its process gone. A container has other numbers of processes: so only an old one."""
    import psutil  # hardly ever needed, and every command would wait for it

    number = folder.name.removeprefix(COPIES).partition("-")[0]
    with suppress(OSError):  # removed meanwhile
        is_old = time.time() - folder.stat().st_mtime > OLD
        return is_old and number.isdecimal() and not psutil.pid_exists(int(number))
    return False
