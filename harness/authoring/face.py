"""Names that a package promises to keep, looked up when they are first used, and those that it gives up."""

import importlib
import warnings
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple


class Renamed(NamedTuple):
    """What became of a name that is given up."""

    new: str
    """The name to use in its place."""
    gone_in: str
    """The version without the old name; the one before it warns."""


def lazy_names(module: str, homes: Mapping[str, str], renamed: Mapping[str, Renamed]) -> Callable[[str], Any]:
    """A module's ``__getattr__``: importing the module imports nothing heavy, and old names warn.

    Args:
        module: Name of the module.
        homes: By public name, the module that it stands in.
        renamed: By old name, what to use; using it gives the new one, with a `DeprecationWarning`.
    """

    def look_up(name: str) -> Any:
        if name in renamed:
            new, gone_in = renamed[name]
            message = f"{module}.{name} is called {new} now; the old name goes in version {gone_in}"
            warnings.warn(message, DeprecationWarning, stacklevel=2)
            return look_up(new)
        if name not in homes:
            raise AttributeError(f"module '{module}' has no attribute '{name}'")
        return getattr(importlib.import_module(homes[name]), name)

    return look_up
