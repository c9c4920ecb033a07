"""The process of a player."""

import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from harness.errors import UsageError

GUARD = Path(__file__).with_name("guard.py")
ENDINGS = {"linux": (".x86_64", ".x86", ""), "darwin": ("",), "win32": (".exe", "")}
"""What a built program's name may end with where a user leaves it out."""
LONGEST = 5.0
"""Seconds that a player gets to end by itself."""
SHOWN = 200
"""Characters of a player's last line that a message quotes."""


class PlayerProcess:
    """A player that runs. It ends with this process, however this process ends."""

    def __init__(self, program: Path, arguments: Sequence[str]) -> None:
        """Start it.

        Raises:
            UsageError: The system does not start it.
        """
        self._output = tempfile.TemporaryFile()  # noqa: SIM115 # closed in `end`
        command = [sys.executable, "-S", "-E", str(GUARD), str(program), *arguments]
        self._guard = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=self._output, stderr=subprocess.STDOUT)

    def ending(self) -> str:
        """How it ended, with its last line; empty while it runs."""
        code = self._guard.poll()
        if code is None:
            return ""
        told = f"exit status {code}" if code < 128 else f"signal {code - 128}"
        line = self._last_line()
        return f"{told}; its last line: {line}" if line else told

    def end(self) -> None:
        """End it, at once if it does not end by itself."""
        try:
            with suppress(subprocess.TimeoutExpired):  # it gets no more time
                self._guard.wait(LONGEST)
        finally:
            if self._guard.stdin:
                self._guard.stdin.close()
            self._guard.wait()
            self._output.close()

    def _last_line(self) -> str:
        self._output.seek(0, os.SEEK_END)
        self._output.seek(max(0, self._output.tell() - 4096))
        lines = [line.strip() for line in self._output.read().decode(errors="replace").splitlines()]
        return next((line[:SHOWN] for line in reversed(lines) if line), "")


def find_program(given: str) -> Path:
    """The program that a user means, in full: Unity's builds end otherwise on each system.

    Raises:
        UsageError: There is none, or it cannot be run.
    """
    path = Path(os.path.abspath(os.path.expanduser(given)))
    if sys.platform == "darwin" and (inside := _inside_app(path)):
        return inside
    for ending in ENDINGS.get(sys.platform, ("",)):
        found = path.with_name(path.name + ending)
        if found.is_file():
            if not os.access(found, os.X_OK):
                raise UsageError(f"file={given}: {found} may not be run. What to do: chmod +x {found}")
            return found
    raise UsageError(f"file={given}: there is no such program. Give the path of the player that Unity built")


def _inside_app(path: Path) -> Path | None:
    """The program in a folder that macOS shows as one file."""
    folder = path if path.suffix == ".app" else path.with_name(f"{path.name}.app")
    return next(iter(sorted((folder / "Contents" / "MacOS").glob("*"))), None)
