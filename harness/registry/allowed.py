"""What a name in a file may run: modules and programs that the user named, and none that only a file names.

``gymnasium.make("package:Name-v0")`` imports `package`, and an environment may start a program. In an experiment file
or a folder of somebody else such a name would run code that lies beside it.
"""

import os
import re
from collections.abc import Iterable

from harness.errors import UsageError
from harness.text import command_text

VARIABLE = "HARNESS_ALLOW_IMPORT"
"""The environment variable with the names, joined by commas. Processes that are started here have it too."""
PROGRAMS = "HARNESS_ALLOW_PROGRAM"
"""The same for programs: their paths in full, joined as those in PATH are."""
_MODULE = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*")
_TYPED = re.compile(rf"\bid=\(?({_MODULE.pattern}):")
_TYPED_XACRO = re.compile(r"(?:--\w+=)?(.+\.(?:xacro|urdf))", re.IGNORECASE)
"""A path that may be of a xacro file, which is a program too."""
_TYPED_PROGRAM = re.compile(r"\bfile=(?:\(([^()]+)\)|([^,()]+))")


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


def allow_programs(paths: Iterable[str]) -> None:
    """Let environments start these programs, from now on."""
    named = [os.path.abspath(os.path.expanduser(path)) for path in paths]
    if named:
        os.environ[PROGRAMS] = os.pathsep.join(sorted({*allowed_programs(), *named}))


def allow_typed(texts: Iterable[str]) -> None:
    """The same for what the user named in a parameter: ``gymnasium:id=(my_package:My-v0)``, ``unity:file=player``."""
    listed = list(texts)
    allow_imports(found[1] for text in listed for found in _TYPED.finditer(text))
    allow_programs((found[1] or found[2]).strip() for text in listed for found in _TYPED_PROGRAM.finditer(text))
    allow_programs(found[1] for text in listed if (found := _TYPED_XACRO.fullmatch(text)))


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


def allowed_programs() -> frozenset[str]:
    """The programs that were named, in full."""
    return frozenset(filter(None, os.environ.get(PROGRAMS, "").split(os.pathsep)))


def require_program(path: str | os.PathLike[str], noun: str) -> None:
    """See whether a program may be started: one that the user named.

    Args:
        path: As it was given.
        noun: What an error begins with, ``file=player``.

    Raises:
        UsageError: The user did not name it.
    """
    if os.path.abspath(os.path.expanduser(path)) not in allowed_programs():
        raise UsageError(
            f"{noun} is a program, and a file or a folder names it: nothing is started for that. If you trust the "
            f"program, add --allow-program {command_text(os.fspath(path))}"
        )
