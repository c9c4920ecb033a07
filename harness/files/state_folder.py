"""Where the harness remembers what belongs to this user, and to no experiment."""

import os
from pathlib import Path

STATE = "XDG_STATE_HOME"
"""The environment variable that names a folder for what programs remember; ``~/.local/state`` without it."""


def state_folder() -> Path:
    """The folder, which may not be there yet.

    Raises:
        RuntimeError: The user has no home folder.
    """
    state = Path(os.environ.get(STATE, ""))
    if not state.is_absolute():  # relative ones are to be ignored, says the standard
        state = Path.home() / ".local" / "state"
    return state / "fd100-harness"
