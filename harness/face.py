"""The face of a room: names that others ask for, each looked up in its own module when it is first used."""

import importlib
from collections.abc import Mapping
from typing import Any


def look_up(room: str, homes: Mapping[str, str], name: str) -> Any:
    """What a room's ``__getattr__`` gives, so that importing the room imports nothing heavy.

    Args:
        room: The room's module.
        homes: By module below it, its names, with a space between them.
        name: The name that is asked for.
    """
    for module, names in homes.items():
        if name in names.split():
            return getattr(importlib.import_module(f"{room}.{module}"), name)
    raise AttributeError(f"module '{room}' has no attribute '{name}'")
