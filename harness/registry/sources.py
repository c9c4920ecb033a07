"""The files that a plugin is made of."""

import hashlib
import importlib.util
import inspect
import sys
from pathlib import Path
from typing import Any


def source_hash(target: Any) -> str:
    """SHA-256 of a plugin's source files, one after the other; empty if it has none."""
    files = source_files(target)
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest() if files else ""


def source_files(target: Any) -> list[Path]:
    """Of a class its own file, those of the classes that it is derived from, and what it names in ``sources``.

    Args:
        target: What a plugin registered. Where it does its work in modules of its own, ``sources`` names them, modules
            or packages; they are not imported.
    """
    classes = inspect.getmro(target) if inspect.isclass(target) else (target,)
    found = [inspect.getsourcefile(part) for part in classes if not _is_pythons_own(part)]
    files = [Path(file) for file in found if file]
    for name in getattr(target, "sources", ()):
        files += _module_files(name)
    return list(dict.fromkeys(files))


def _is_pythons_own(part: Any) -> bool:
    return part.__module__.partition(".")[0] in sys.stdlib_module_names


def _module_files(name: str) -> list[Path]:
    """Of a module, or of all modules of a package."""
    spec = importlib.util.find_spec(name)
    if spec is None:
        return []
    folders = [Path(folder) for folder in spec.submodule_search_locations or ()]
    if folders:
        return sorted(file for folder in folders for file in folder.rglob("*.py"))
    return [Path(spec.origin)] if spec.origin else []
