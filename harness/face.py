"""The face of a room or a module: names that others ask for, each looked up in its own module when it is first used."""

import ast
import importlib
from collections.abc import Callable
from pathlib import Path
from typing import Any


def face_of(module: str, path: str) -> tuple[list[str], Callable[[str], Any]]:
    """A module's ``__all__`` and ``__getattr__``: the names that it imports as ``X as X``, which makes them public.

    Those that it imports for type checkers alone are looked up when they are first used. So each name is written once,
    and importing the module imports nothing heavy.

    Args:
        module: The module's name.
        path: The module's own file.
    """
    imports = [
        it for it in ast.walk(ast.parse(Path(path).read_text(encoding="utf-8"))) if isinstance(it, ast.ImportFrom)
    ]
    homes = {it.name: "." * node.level + (node.module or "") for node in imports for it in node.names if it.asname}

    def look_up(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module '{module}' has no attribute '{name}'")
        return getattr(importlib.import_module(homes[name], module), name)

    return sorted(homes), look_up
