"""Modules that an environment's id may import: those that the user named, and none that a file names.

``gymnasium.make("package:Name-v0")`` imports `package`. In an experiment file or a folder of somebody else such an id
would run code that lies beside it.
"""

import os
import re
from collections.abc import Iterable

from harness.errors import UsageError

VARIABLE = "HARNESS_ALLOW_IMPORT"
"""The environment variable with the names, joined by commas. Processes that are started here have it too."""
_MODULE = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*")
_TYPED = re.compile(rf"\bid=\(?({_MODULE.pattern}):")


def allow_imports(modules: Iterable[str]) -> None:
    """Let ids import these modules, from now on.

    Raises:
        UsageError: One of them is no module's name.
    """
    names = list(modules)
    for name in names:
        if not _MODULE.fullmatch(name):
            raise UsageError(f"--allow-import {name}: give the name of a module, such as my_package")
    if names:
        os.environ[VARIABLE] = ",".join(sorted({*allowed_imports(), *names}))


def allow_typed(texts: Iterable[str]) -> None:
    """The same for modules that the user named in an id, as in ``gymnasium:id=(my_package:My-v0)``."""
    allow_imports(found[1] for text in texts for found in _TYPED.finditer(text))


def allowed_imports() -> frozenset[str]:
    """The modules that were named."""
    return frozenset(filter(None, os.environ.get(VARIABLE, "").split(",")))


def require_allowed(name: str) -> None:
    """See whether an environment may be made by its id.

    Args:
        name: The id, such as ``Pendulum-v1`` or ``my_package:My-v0``.

    Raises:
        UsageError: It would import a module that the user did not name.
    """
    module, colon, _ = name.partition(":")
    if colon and module not in allowed_imports():
        raise UsageError(
            f"The id '{name}' imports the module '{module}', and a file or a folder names it: nothing is imported for "
            f"that. If you trust the module, add --allow-import {module}"
        )
