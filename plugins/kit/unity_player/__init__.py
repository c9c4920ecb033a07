"""A player without Unity: a program that speaks ML-Agents' protocol and moves the baseline's arm.

It is for tests of what talks with Unity, and for people who have no build at hand. It needs the extra ``unity``::

    python -m harness_plugins.kit.unity_player --write player
    harness run --task unity:file=player,places=unity-arm --algo sac-fast --reward own,arp
"""

import sys
from collections.abc import Sequence
from pathlib import Path

from harness.files.bounded import write_whole
from harness.text import command_text

MODULE = "harness_plugins.kit.unity_player"


def write_unity_player(path: Path, arguments: Sequence[str] = ()) -> Path:
    """Write a program that starts the player, as Unity's build is one file that can be run.

    Args:
        path: Of the program; on Windows it has to end with ``.bat``.
        arguments: Of the player, see ``python -m harness_plugins.kit.unity_player --help``.

    Returns:
        The path.

    Raises:
        OSError: It cannot be written.
    """
    command = command_text(sys.executable, "-m", MODULE, *arguments)
    is_windows = path.suffix == ".bat"
    write_whole(path, f"@{command} %*\r\n" if is_windows else f'#!/bin/sh\nexec {command} "$@"\n')
    path.chmod(0o755)
    return path
