"""Names that a package promises to keep, looked up when they are first used."""

import ast
import importlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any


def lazy_names(module: str, homes: Mapping[str, str]) -> Callable[[str], Any]:
    """A module's ``__getattr__``: importing the module imports nothing heavy.

    Args:
        module: Name of the module.
        homes: The module of each public name, by name.
    """

    def look_up(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module '{module}' has no attribute '{name}'")
        return getattr(importlib.import_module(homes[name]), name)

    return look_up


def homes_in(path: str) -> dict[str, str]:
    """The module of each name that a face imports for type checkers alone, so that a face lists each name once.

    Args:
        path: The face's own file.
    """
    tree = ast.parse(Path(path).read_text(encoding="utf-8"))
    blocks = [node.body for node in tree.body if isinstance(node, ast.If)]
    imports = [node for block in blocks for node in block if isinstance(node, ast.ImportFrom)]
    return {alias.name: node.module or "" for node in imports for alias in node.names}
