"""The files that a plugin is made of."""

import ast
import hashlib
import importlib.util
import inspect
import sys
from collections.abc import Iterable, Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

BESIDE = "__harness_beside__"
"""The attribute of the module of a plugin file that holds the copies of the files beside it that it imports."""


def source_hash(target: Any) -> str:
    """SHA-256 of a plugin's source files, one after the other; empty if it has none."""
    files = source_files(target)
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest() if files else ""


def source_files(target: Any) -> list[Path]:
    """The file of a class, those of the classes that it is derived from, and what it names in ``sources``.

    Of what a plugin file has, also the files beside it that it imports.

    Args:
        target: What a plugin registered. Where it does its work in modules of its own, ``sources`` names them, modules
            or packages; they are not imported.
    """
    classes = inspect.getmro(target) if inspect.isclass(target) else (target,)
    found = [inspect.getsourcefile(part) for part in classes if not _is_pythons_own(part)]
    files = [Path(file) for file in found if file]
    for name in getattr(target, "sources", ()):
        files += _module_files(name)
    files += getattr(sys.modules.get(target.__module__), BESIDE, ())
    return list(dict.fromkeys(files))


def _is_pythons_own(part: Any) -> bool:
    return part.__module__.partition(".")[0] in sys.stdlib_module_names


def _module_files(name: str) -> list[Path]:
    """The files of a module, or of all modules of a package."""
    spec = importlib.util.find_spec(name)
    if spec is None:
        return []
    folders = [Path(folder) for folder in spec.submodule_search_locations or ()]
    if folders:
        return sorted(file for folder in folders for file in folder.rglob("*.py"))
    return [Path(spec.origin)] if spec.origin else []


def digest_of_modules(names: Iterable[str]) -> str:
    """SHA-256 of the source files of modules and packages, which are not imported for it."""
    return _digest(file for name in names for file in _module_files(name))


def fingerprint(built: Any) -> str:
    """A digest of all that decides what a built plugin computes: its class, its parameters, its source files.

    Modules of its own top-level package that its module imports count too, and so do the parts that it is built of.
    """
    types = dict.fromkeys(type(part) for part in _parts_of(built))
    files = [file for part in types for file in (*source_files(part), *_files_behind(part.__module__))]
    return hashlib.sha256(f"{description(built)} {_digest(dict.fromkeys(files))}".encode()).hexdigest()


def _parts_of(built: Any, around: tuple[int, ...] = ()) -> Iterator[Any]:
    """The object, and those that it holds which are no plain values; one that holds itself, once."""
    if _is_plain(built) or id(built) in around:
        return
    yield built
    for value in getattr(built, "__dict__", {}).values():
        yield from _parts_of(value, (*around, id(built)))


def description(built: Any, around: tuple[int, ...] = ()) -> str:
    """The class of a built plugin and its attributes, whatever the order in which they were set.

    Within a process, whose classes stay what they are, this is all that decides what it computes.
    """
    if _is_plain(built):
        return repr(built)
    if id(built) in around:
        return "itself"
    values = sorted(getattr(built, "__dict__", {}).items())
    told = ", ".join(f"{name}={description(value, (*around, id(built)))}" for name, value in values)
    return f"{type(built).__module__}.{type(built).__qualname__}({told})"


def _is_plain(value: Any) -> bool:
    return _is_pythons_own(type(value)) or type(value).__module__.partition(".")[0] == "numpy"


def _files_behind(module: str) -> list[Path]:
    """The files of a module and of those that it imports from its own distribution, and so on."""
    root, found, waiting = module.partition(".")[0], dict[str, Path | None](), [module]
    while waiting:
        name = waiting.pop()
        if name in found or name.partition(".")[0] != root:
            continue
        found[name] = file = _source_of(name)
        if file is not None:
            waiting += imports_of(_content(str(file)), name if file.name == "__init__.py" else name.rpartition(".")[0])
    return [file for _, file in sorted(found.items()) if file is not None]


def _source_of(module: str) -> Path | None:
    try:
        spec = importlib.util.find_spec(module)
    except (ImportError, ValueError):  # a class in a module looks like a module in a package; a test has no spec
        return None
    return Path(spec.origin) if spec and spec.origin and spec.origin.endswith(".py") else None


@lru_cache(maxsize=1024)  # to parse a source takes milliseconds, and every cell asks
def imports_of(source: bytes, package: str) -> tuple[str, ...]:
    """Whatever the source of a module in `package` imports, also inside functions; names in a module among them."""
    found: list[str] = []
    for node in _statements(ast.parse(source)):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            parent = package.rsplit(".", node.level - 1)[0] if node.level else ""
            base = ".".join(part for part in (parent, node.module) if part)
            found += [base, *(f"{base}.{alias.name}" for alias in node.names)]
    return tuple(found)


def _statements(module: ast.Module) -> Iterator[ast.AST]:
    """Also those inside of others; not the many expressions, which import nothing."""
    waiting: list[ast.AST] = [module]
    while waiting:
        statement = waiting.pop()
        yield statement
        for part in ("body", "handlers", "orelse", "finalbody", "cases"):
            waiting += getattr(statement, part, ())


def _digest(files: Iterable[Path]) -> str:
    found = hashlib.sha256()
    for file in files:
        found.update(hashlib.sha256(_content(str(file))).digest())
    return found.hexdigest()


@lru_cache(maxsize=512)
def _content(file: str) -> bytes:
    """The content of a source file, as it was when it was first asked for: what runs was loaded before."""
    return Path(file).read_bytes()
